#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace corrsel::core {

/// The part of an image in which features are looked for. Matrices are shared, not copied.
struct FeatureRegion {
  cv::Rect area;  ///< px; empty = the whole image; what reaches over the image is cut off
  cv::Mat mask;   ///< 8-bit, one channel, size of the whole image; features whose centre lies on a zero are
                  ///< dropped; empty = none
};

}  // namespace corrsel::core
