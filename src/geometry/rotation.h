#pragma once

#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>  // normalize()

#include "geometry/rays.h"

namespace corrsel::core {

/// Squared error of match i under d' = R d, px^2: the squared distance of the directions over the sum of
/// the squared pixel angles of both rays. The variance of each of its two coordinates is that of a feature's.
inline double squaredRotationError(const cv::Matx33d& rotation, const RayMatches& matches, std::size_t i) {
  const double left = matches.left.pixelAngle(i), right = matches.right.pixelAngle(i);
  const cv::Vec3d difference = rotation * matches.left.direction(i) - matches.right.direction(i);
  return difference.dot(difference) / (left * left + right * right);
}

/// The rotation vector of a rotation: axis times angle, rad.
inline cv::Vec3d rotationVector(const cv::Matx33d& r) {
  constexpr double kSmallSine = 1e-9;
  const cv::Vec3d axis = 0.5 * cv::Vec3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double sine = cv::norm(axis), cosine = 0.5 * (r(0, 0) + r(1, 1) + r(2, 2) - 1);
  const double angle = std::atan2(sine, cosine);
  if (sine > kSmallSine) return axis * (angle / sine);
  if (cosine > 0) return axis;
  // Half a turn: R = 2 n n^T - I.
  int largest = 0;
  for (int i = 1; i < 3; ++i) {
    if (r(i, i) > r(largest, largest)) largest = i;
  }
  cv::Vec3d column(r(0, largest), r(1, largest), r(2, largest));
  column[largest] += 1;
  return cv::normalize(column) * angle;
}

}  // namespace corrsel::core
