#include "features/detectors/akaze.h"

namespace corrsel::core {

void AkazeOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.number({"threshold", 0, 1, "-", "AKAZE: smallest determinant of the Hessian"},
                 &AkazeOptions::threshold);
  visitor.integer({"octaves", 1, 8, "-", "AKAZE: octaves of the scale space"}, &AkazeOptions::octaves);
  visitor.integer({"octave_layers", 1, 8, "-", "AKAZE: layers per octave"}, &AkazeOptions::octave_layers);
}

AkazeDetector::AkazeDetector(const AkazeOptions& options)
    : OpenCvDetector(
          "akaze",
          [options](const cv::Size&, int) {
            return cv::AKAZE::create(cv::AKAZE::DESCRIPTOR_MLDB, 0, 3, static_cast<float>(options.threshold),
                                     options.octaves, options.octave_layers);
          },
          16),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
