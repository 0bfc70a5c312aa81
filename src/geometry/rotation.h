#pragma once

#include <cstddef>
#include <opencv2/core/matx.hpp>

#include "geometry/rays.h"

namespace corrsel::core {

/// Squared error of match i under d' = R d, px^2: the squared distance of the directions over the sum of
/// the squared pixel angles of both rays. The variance of each of its two coordinates is that of a feature's.
inline double squaredRotationError(const cv::Matx33d& rotation, const RayMatches& matches, std::size_t i) {
  const double left = matches.left.pixelAngle(i), right = matches.right.pixelAngle(i);
  const cv::Vec3d difference = rotation * matches.left.direction(i) - matches.right.direction(i);
  return difference.dot(difference) / (left * left + right * right);
}

}  // namespace corrsel::core
