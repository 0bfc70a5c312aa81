#pragma once

#include <opencv2/core/matx.hpp>

namespace corrsel::core {

/// The skew-symmetric matrix [v]_x, for which [v]_x w is the cross product v x w.
inline cv::Matx33d crossMatrix(const cv::Vec3d& v) {
  return {0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0};
}

}  // namespace corrsel::core
