#include "features/detectors/orb.h"

namespace corrsel::core {

void OrbOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.number({"scale_factor", 1.05, 3, "-", "ORB: scale between pyramid levels"},
                 &OrbOptions::scale_factor);
  visitor.integer({"levels", 1, 16, "-", "ORB: levels of the pyramid"}, &OrbOptions::levels);
  visitor.integer({"fast_threshold", 0, 255, "grey levels", "ORB: smallest corner contrast"},
                  &OrbOptions::fast_threshold);
  visitor.integer({"patch_size", 5, 127, "px",
                   "ORB: side of the described patch; features nearer to the border are lost"},
                  &OrbOptions::patch_size);
}

CvOrbOptions cvOrbOptions(const OrbOptions& options) {
  CvOrbOptions result;
  static_cast<DetectorOptions&>(result) = options;
  result.scale_factor = options.scale_factor;
  result.levels = options.levels;
  result.fast_threshold = options.fast_threshold;
  result.patch_size = options.patch_size;
  return result;
}

OrbDetector::OrbDetector(const OrbOptions& options)
    : CvOrbDetector(cvOrbOptions(options), "orb"), options_(options) {
  options_.check();
}

}  // namespace corrsel::core
