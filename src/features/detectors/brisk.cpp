#include "features/detectors/brisk.h"

#include <algorithm>

namespace corrsel::core {

void BriskOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.integer({"threshold", 1, 255, "grey levels", "BRISK: smallest corner contrast"},
                  &BriskOptions::threshold);
  visitor.integer({"octaves", 0, 8, "-", "BRISK: octaves of the pyramid; 0 = one scale"},
                  &BriskOptions::octaves);
  visitor.number({"pattern_scale", 0.3, 3, "-", "BRISK: scale of the sampling pattern"},
                 &BriskOptions::pattern_scale);
}

CreateOpenCv briskCreator(const BriskOptions& options) {
  return [options](const cv::Size& size, int) {
    // OpenCV fails on a pyramid that shrinks to nothing.
    int octaves = 0;
    while (octaves < options.octaves && std::min(size.width, size.height) >> (octaves + 1) >= 2) ++octaves;
    return cv::BRISK::create(options.threshold, octaves, static_cast<float>(options.pattern_scale));
  };
}

BriskDetector::BriskDetector(const BriskOptions& options)
    : OpenCvDetector("brisk", briskCreator(options), kBriskBorder, kAgastDiameter / kBriskSize),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
