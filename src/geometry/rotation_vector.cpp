#include "geometry/rotation_vector.h"

#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/cross_matrix.h"

namespace corrsel::core {
namespace {

constexpr double kSmallSine = 1e-9;

}  // namespace

cv::Matx33d rotationFromVector(const cv::Vec3d& w) {
  const double squared = w.dot(w), angle = std::sqrt(squared);
  const bool small = angle < 1e-4;  // below it the series are exact
  const double first = small ? 1 - squared / 6 : std::sin(angle) / angle;
  const double half = std::sin(0.5 * angle);
  const double second = small ? 0.5 - squared / 24 : 2 * half * half / squared;
  const cv::Matx33d cross = crossMatrix(w);
  return cv::Matx33d::eye() + cross * first + cross * cross * second;
}

cv::Vec3d rotationVector(const cv::Matx33d& r) {
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

cv::Matx33d rotationFromQuaternion(const cv::Vec4d& q) {
  const cv::Vec3d axis(q[1], q[2], q[3]);
  const double sine = cv::norm(axis);
  if (sine == 0) return cv::Matx33d::eye();
  return rotationFromVector(axis * (2 * std::atan2(sine, q[0]) / sine));
}

}  // namespace corrsel::core
