#include "corrsel/evaluation/pinhole_view.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/rays.h"

namespace corrsel::core {
namespace {

bool isUnrectified(const std::optional<Camera>& camera) { return camera && !camera->isPlainPinhole(); }

void moveThrough(const Camera& camera, const cv::Matx33d& pinhole, std::vector<float>& x,
                 std::vector<float>& y) {
  static const double least_cosine = std::cos(kPinholeAngle * CV_PI / 180);
  Rays rays;
  unproject(camera, x.data(), y.data(), x.size(), rays);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const cv::Vec3d ray = rays.direction(i), seen = pinhole * ray;
    const bool visible = ray[2] >= least_cosine;  // not where the ray is NaN
    x[i] = visible ? static_cast<float>(seen[0] / seen[2]) : std::numeric_limits<float>::quiet_NaN();
    y[i] = visible ? static_cast<float>(seen[1] / seen[2]) : std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace

cv::Matx33d pinholeOf(const Camera& camera) {
  if (camera.model != Camera::Model::kEquirectangular) return camera.matrix;
  const double focal_length = camera.size.width / (2 * CV_PI);
  return {focal_length,
          0,
          0.5 * (camera.size.width - 1),  //
          0,
          focal_length,
          0.5 * (camera.size.height - 1),
          0,
          0,
          1};
}

Correspondences throughPinholes(const Correspondences& matches, const RelativePose& pose) {
  Correspondences seen = matches;
  if (!isUnrectified(matches.left_camera) && !isUnrectified(matches.right_camera)) return seen;
  seen.left_frame.clear();
  seen.right_frame.clear();
  if (isUnrectified(matches.left_camera)) {
    moveThrough(*matches.left_camera, pose.left_camera, seen.left_x, seen.left_y);
    seen.left_camera.reset();
  }
  if (isUnrectified(matches.right_camera)) {
    moveThrough(*matches.right_camera, pose.right_camera, seen.right_x, seen.right_y);
    seen.right_camera.reset();
  }
  return seen;
}

}  // namespace corrsel::core
