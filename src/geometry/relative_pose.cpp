#include "corrsel/relative_pose.h"

#include <opencv2/core.hpp>  // inv()
#include <stdexcept>
#include <string>

#include "geometry/checked_matrix.h"
#include "geometry/cross_matrix.h"

namespace corrsel::core {

void RelativePose::check() const {
  requireCameraMatrix("left_camera", left_camera);
  requireCameraMatrix("right_camera", right_camera);
  requireRotation("rotation", rotation);
  requireFinite("translation", translation);
}

cv::Matx33d RelativePose::fundamental() const {
  if (cv::norm(translation) == 0) {
    throw std::invalid_argument("translation = 0: a camera that only turned has no fundamental matrix");
  }
  const cv::Matx33d f = right_camera.inv().t() * crossMatrix(translation) * rotation * left_camera.inv();
  return f * (1.0 / cv::norm(f));
}

}  // namespace corrsel::core
