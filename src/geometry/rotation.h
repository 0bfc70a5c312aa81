#pragma once

#include <cstddef>
#include <opencv2/core/matx.hpp>

#include "geometry/rays.h"

namespace corrsel::core {

/// Squared error of match i under d' = R d, px^2: the squared distance of the directions over the mean square
/// of the pixel angles of both rays.
inline double squaredRotationError(const cv::Matx33d& rotation, const RayMatches& matches, std::size_t i) {
  const double left = matches.left.pixelAngle(i), right = matches.right.pixelAngle(i);
  const cv::Vec3d difference = rotation * matches.left.direction(i) - matches.right.direction(i);
  return 2 * difference.dot(difference) / (left * left + right * right);
}

}  // namespace corrsel::core
