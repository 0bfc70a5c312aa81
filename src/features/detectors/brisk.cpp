#include "features/detectors/brisk.h"

#include <algorithm>

namespace corrsel::core {

void BriskOptions::visit(OptionVisitor& visitor) const {
  visitCap(visitor);
  visitor.integer({"threshold", 1, 255, "grey levels", "BRISK: smallest corner contrast"},
                  &BriskOptions::threshold);
  visitor.integer({"octaves", 0, 8, "-", "BRISK: octaves of the pyramid; 0 = one scale"},
                  &BriskOptions::octaves);
  visitor.number({"pattern_scale", 0.3, 3, "-", "BRISK: scale of the sampling pattern"},
                 &BriskOptions::pattern_scale);
}

namespace {

/// OpenCV's keypoint size on the first level, and the diameter of the circle of pixels that AGAST looks at.
constexpr double kBasicSize = 12, kAgastDiameter = 7;
constexpr int kBorder = 8;

OpenCvDetector::Create create(const BriskOptions& options) {
  return [options](const cv::Size& size, int) {
    // OpenCV fails on a pyramid that shrinks to nothing.
    int octaves = 0;
    while (octaves < options.octaves && std::min(size.width, size.height) >> (octaves + 1) >= 2) ++octaves;
    return cv::BRISK::create(options.threshold, octaves, static_cast<float>(options.pattern_scale));
  };
}

}  // namespace

BriskDetector::BriskDetector(const BriskOptions& options)
    : OpenCvDetector("brisk", create(options), kBorder, kAgastDiameter / kBasicSize), options_(options) {
  options_.check();
}

BriskDescriptor::BriskDescriptor(const BriskOptions& options)
    : OpenCvDescriptor("brisk", create(options), kBorder,
                       [](const cv::Size&, cv::KeyPoint& keypoint) {
                         keypoint.size *= static_cast<float>(kBasicSize / kAgastDiameter);
                       }),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
