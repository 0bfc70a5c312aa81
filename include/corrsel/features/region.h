#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace corrsel::core {

/// The part of an image in which features are searched. Copies share the pixels of the mask.
struct FeatureRegion {
  /// px; empty = the whole image. The part beyond the image is cut off.
  cv::Rect area;
  /// 8-bit, one channel, of the size of the whole image; empty = none. Features whose centre lies on a zero
  /// are dropped.
  cv::Mat mask;
};

}  // namespace corrsel::core
