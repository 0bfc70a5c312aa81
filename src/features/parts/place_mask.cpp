#include "features/parts/place_mask.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "features/parts/feature_list.h"

namespace corrsel::core {

AreaTransform::AreaTransform(const cv::Size& seen, const cv::Rect& area)
    : reduced_(seen != area.size()),
      left_(static_cast<float>(area.x)),
      top_(static_cast<float>(area.y)),
      x_scale_(static_cast<float>(area.width) / static_cast<float>(seen.width)),
      y_scale_(static_cast<float>(area.height) / static_cast<float>(seen.height)) {}

void AreaTransform::apply(Features& features) const {
  const float scale = std::sqrt(x_scale_ * y_scale_);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    cv::KeyPoint& keypoint = features.keypoints[i];
    AffineFrame& frame = features.frames[i];
    if (reduced_) {
      keypoint.size *= scale;
      for (const std::size_t k : {0, 1, 3, 4}) frame[k] *= scale;
    }
    keypoint.pt = (*this)(keypoint.pt);
    frame[2] = keypoint.pt.x;
    frame[5] = keypoint.pt.y;
  }
}

PlaceMask::PlaceMask(const cv::Mat& mask, const AreaTransform& to_mask) : mask_(mask), to_mask_(to_mask) {}

bool PlaceMask::allows(const cv::Point2f& place) const {
  if (everywhere()) return true;
  const cv::Point2f at = to_mask_(place);
  const int x = std::clamp(static_cast<int>(std::floor(at.x + 0.5F)), 0, mask_.cols - 1);
  const int y = std::clamp(static_cast<int>(std::floor(at.y + 0.5F)), 0, mask_.rows - 1);
  return mask_.at<std::uint8_t>(y, x) != 0;
}

void PlaceMask::apply(Features& features) const {
  if (everywhere()) return;
  std::vector<char> keep;
  keep.reserve(features.keypoints.size());
  for (const cv::KeyPoint& keypoint : features.keypoints) keep.push_back(allows(keypoint.pt) ? 1 : 0);
  keepFeatures(keep, features);
}

}  // namespace corrsel::core
