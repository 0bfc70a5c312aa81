#include "corrsel/relative_pose.h"

#include <opencv2/core.hpp>  // inv()
#include <stdexcept>
#include <string>

#include "geometry/checked_matrix.h"
#include "geometry/cross_matrix.h"

namespace corrsel::core {
namespace {

constexpr double kRotationTolerance = 1e-4;

}  // namespace

void RelativePose::check() const {
  requireCameraMatrix("left_camera", left_camera);
  requireCameraMatrix("right_camera", right_camera);
  requireFinite("rotation", rotation);
  requireFinite("translation", translation);
  const double fault = cv::norm(rotation * rotation.t() - cv::Matx33d::eye());
  if (!(fault <= kRotationTolerance) || cv::determinant(rotation) < 0) {
    throw std::invalid_argument(
        "rotation = " + matrixText(rotation) +
        " is not a rotation: its rows must be orthogonal, of length 1, and its determinant 1");
  }
}

cv::Matx33d RelativePose::fundamental() const {
  if (cv::norm(translation) == 0) {
    throw std::invalid_argument("translation = 0: a camera that only turned has no fundamental matrix");
  }
  const cv::Matx33d f = right_camera.inv().t() * crossMatrix(translation) * rotation * left_camera.inv();
  return f * (1.0 / cv::norm(f));
}

}  // namespace corrsel::core
