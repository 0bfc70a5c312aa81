#include "corrsel/features/detector.h"

#include <cmath>

namespace corrsel::core {

void DetectorOptions::visitCap(OptionVisitor& visitor) {
  visitor.integer({"max_features", 0, 100000, "-", "Strongest features kept; 0 = no cap"}, max_features);
  visitor.flag("spread", "With max_features: keep the strongest of every part of the image", spread);
  visitor.number({"max_megapixels", 0.01, 1000, "10^6 px", "Larger images are reduced to this size first"},
                 max_megapixels);
}

std::vector<AffineFrame> similarityFrames(const std::vector<cv::KeyPoint>& keypoints) {
  std::vector<AffineFrame> frames;
  frames.reserve(keypoints.size());
  for (const cv::KeyPoint& keypoint : keypoints) {
    const double angle = keypoint.angle * CV_PI / 180, radius = keypoint.size / 2.0;
    const auto c = static_cast<float>(radius * std::cos(angle));
    const auto s = static_cast<float>(radius * std::sin(angle));
    frames.push_back({c, -s, keypoint.pt.x, s, c, keypoint.pt.y});
  }
  return frames;
}

}  // namespace corrsel::core
