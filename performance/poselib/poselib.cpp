#include <PoseLib/poselib.h>

#include <cstdint>
#include <memory>

#include "pose.h"

namespace corrsel::performance {
namespace {

/// The lenses of the scenes have no coefficients beyond these.
poselib::Camera cameraOf(const core::Camera& camera) {
  const cv::Matx33d& k = camera.matrix;
  const auto& d = camera.distortion;
  const bool fisheye = camera.model == core::Camera::Model::kFisheye;
  std::vector<double> parameters = {k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
  if (fisheye) parameters.insert(parameters.end(), d.begin(), d.begin() + 4);
  return poselib::Camera(fisheye ? "OPENCV_FISHEYE" : "PINHOLE", parameters, camera.size.width,
                         camera.size.height);
}

std::vector<poselib::Point2D> pointsOf(const std::vector<cv::Point2d>& points) {
  std::vector<poselib::Point2D> result;
  for (const cv::Point2d& point : points) result.emplace_back(point.x, point.y);
  return result;
}

struct Input {
  explicit Input(const core::Correspondences& matches)
      : sorted(sortedMatches(matches)),
        left(pointsOf(sorted.left)),
        right(pointsOf(sorted.right)),
        left_camera(cameraOf(*matches.left_camera)),
        right_camera(cameraOf(*matches.right_camera)) {
    options.max_epipolar_error = kPoseThreshold;
    options.progressive_sampling = !matches.distance.empty();
  }

  Mask select() const {
    poselib::CameraPose pose;
    std::vector<char> inliers;
    poselib::estimate_relative_pose(left, right, left_camera, right_camera, options, poselib::BundleOptions(),
                                    &pose, &inliers);
    return sorted.maskOf(inliers, sorted.rows.size());
  }

  SortedMatches sorted;
  std::vector<poselib::Point2D> left, right;
  poselib::Camera left_camera, right_camera;
  poselib::RansacOptions options;
};

}  // namespace

Method poseLibPose(const CalibratedSceneSpec& scene, std::size_t scenes) {
  Method method{"PoseLib", {}, scenes, [](const std::vector<Scene>& scenes_given) -> Call {
                  const auto inputs = std::make_shared<std::vector<Input>>();
                  for (const Scene& given : scenes_given) inputs->emplace_back(given.matches);
                  return [inputs](std::size_t k) { return (*inputs)[k].select(); };
                }};
  method.setScene(scene);
  return method;
}

}  // namespace corrsel::performance
