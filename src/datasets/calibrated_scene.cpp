#include "corrsel/datasets/calibrated_scene.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "corrsel/evaluation/pinhole_view.h"
#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr double kNearest = 4, kFarthest = 12, kMeanDistance = 8;
constexpr double kPlaneTilt = 0.4;
constexpr double kLeastTurn = 2 * CV_PI / 180, kLargestTurn = 15 * CV_PI / 180;

Camera pinhole(double focal_length) {
  Camera camera;
  camera.size = {1280, 960};
  camera.matrix = {focal_length, 0, 639.5, 0, focal_length, 479.5, 0, 0, 1};
  return camera;
}

cv::Vec3d normalVector(Random& random) {
  cv::Vec3d vector;
  for (int i = 0; i < 3; ++i) vector[i] = random.normal();
  return vector;
}

cv::Point2d anywhere(const cv::Size& size, Random& random) {
  const double x = random.uniform(0, size.width - 1);
  const double y = random.uniform(0, size.height - 1);
  return {x, y};
}

bool isInside(const cv::Size& size, const cv::Point2d& p) {
  return p.x >= 0 && p.y >= 0 && p.x <= size.width - 1 && p.y <= size.height - 1;
}

/// exp([axis]_x angle) for a unit axis (Rodrigues).
cv::Matx33d rotationAbout(const cv::Vec3d& axis, double angle) {
  const cv::Matx33d cross(0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0);
  return cv::Matx33d::eye() + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
}

RelativePose drawPose(const CalibratedSceneSpec& spec, Random& random) {
  RelativePose pose;
  pose.left_camera = pinholeOf(spec.left_camera);
  pose.right_camera = pinholeOf(spec.right_camera);
  const cv::Vec3d axis = cv::normalize(normalVector(random));
  const double angle = random.uniform(kLeastTurn, kLargestTurn);
  const cv::Vec3d direction = cv::normalize(normalVector(random));
  if (spec.motion == SceneMotion::kRest) return pose;
  pose.rotation = rotationAbout(axis, angle);
  if (spec.motion == SceneMotion::kRotation) return pose;
  const double length = spec.baseline * kMeanDistance;
  pose.translation =
      spec.motion == SceneMotion::kForward ? pose.rotation * cv::Vec3d(0, 0, -length) : direction * length;
  return pose;
}

/// A generated scene before its matches are drawn.
class Generator {
 public:
  explicit Generator(const CalibratedSceneSpec& spec) : spec_(spec), random_(spec.seed) {
    pose_ = drawPose(spec, random_);
    normal_ = {kPlaneTilt * random_.normal(), 0, -1};
    normal_[1] = kPlaneTilt * random_.normal();
  }

  const RelativePose& pose() const { return pose_; }
  Random& random() { return random_; }

  /// A match of a point that both cameras see.
  std::pair<cv::Point2d, cv::Point2d> inlier() {
    for (;;) {
      cv::Point2d left = anywhere(spec_.left_camera.size, random_);
      const double drawn = random_.uniform(kNearest, kFarthest);
      Ray ray;
      if (!unproject(spec_.left_camera, left, ray)) continue;
      double distance = drawn;
      if (spec_.motion == SceneMotion::kPlane) distance = -kMeanDistance / normal_.dot(ray.direction);
      if (!(distance > 0)) continue;
      cv::Point2d right;
      const cv::Vec3d point = pose_.rotation * (distance * ray.direction) + pose_.translation;
      if (!project(spec_.right_camera, point, right)) continue;
      left += noise();
      right += noise();
      if (isInside(spec_.left_camera.size, left) && isInside(spec_.right_camera.size, right)) {
        return {left, right};
      }
    }
  }

  std::pair<cv::Point2d, cv::Point2d> outlier() {
    const cv::Point2d left = anywhere(spec_.left_camera.size, random_);
    const cv::Point2d right = anywhere(spec_.right_camera.size, random_);
    return {left, right};
  }

 private:
  cv::Point2d noise() {
    const double x = spec_.noise * random_.normal();
    const double y = spec_.noise * random_.normal();
    return {x, y};
  }

  const CalibratedSceneSpec& spec_;
  Random random_;
  RelativePose pose_;
  cv::Vec3d normal_;  ///< of the plane normal . X = -kMeanDistance
};

Motion motionOf(SceneMotion motion) {
  switch (motion) {
    case SceneMotion::kRest:
      return Motion::kRest;
    case SceneMotion::kRotation:
      return Motion::kRotation;
    case SceneMotion::kPlane:
      return Motion::kPlanar;
    case SceneMotion::kGeneral:
    case SceneMotion::kForward:
      break;
  }
  return Motion::kGeneral;
}

void requireSize(const Camera& camera, const char* side) {
  camera.check();
  if (!camera.size.empty()) return;
  throw std::invalid_argument(std::string(side) + "_camera has no size; a scene needs that of its images");
}

std::vector<std::uint8_t> drawInliers(const CalibratedSceneSpec& spec, Random& random) {
  std::vector<std::uint8_t> inlier(spec.n, 0);
  std::fill_n(inlier.begin(), std::llround(spec.inlier_ratio * static_cast<double>(spec.n)), std::uint8_t{1});
  for (std::size_t i = spec.n; i > 1; --i) {
    std::swap(inlier[i - 1], inlier[random.index(static_cast<std::uint32_t>(i))]);
  }
  return inlier;
}

}  // namespace

Camera scenePinhole() { return pinhole(600); }

Camera sceneRational() {
  Camera camera = pinhole(600);
  camera.distortion = {0.3, 0.02, 5e-4, -3e-4, 0, 0.5, 0.06, 0};
  return camera;
}

Camera sceneFisheye() {
  Camera camera = pinhole(400);
  camera.model = Camera::Model::kFisheye;
  camera.distortion = {-0.02, 0.003};
  return camera;
}

Camera scenePanorama() {
  Camera camera;
  camera.model = Camera::Model::kEquirectangular;
  camera.size = {1280, 640};
  return camera;
}

std::string toString(SceneMotion motion) {
  switch (motion) {
    case SceneMotion::kRest:
      return "rest";
    case SceneMotion::kRotation:
      return "rotation";
    case SceneMotion::kGeneral:
      return "general";
    case SceneMotion::kForward:
      return "forward";
    case SceneMotion::kPlane:
      return "plane";
  }
  throw std::invalid_argument("unknown motion " + std::to_string(static_cast<int>(motion)));
}

CalibratedScene makeCalibratedScene(const CalibratedSceneSpec& spec) {
  requireSize(spec.left_camera, "left");
  requireSize(spec.right_camera, "right");
  Generator generator(spec);
  Random& random = generator.random();
  CalibratedScene scene;
  scene.pose = generator.pose();
  scene.motion = motionOf(spec.motion);
  scene.inlier = drawInliers(spec, random);
  Correspondences& matches = scene.matches;
  for (const bool inlier : scene.inlier) {
    const auto [left, right] = inlier ? generator.inlier() : generator.outlier();
    matches.add(left, right);
    const double ratio = inlier ? 0.60 + 0.12 * random.normal() : 0.78 + 0.10 * random.normal();
    const double second = random.uniform(200, 400);
    if (!spec.distances) continue;
    matches.second_distance.push_back(static_cast<float>(second));
    matches.distance.push_back(static_cast<float>(std::clamp(ratio, 0.05, 1.0) * second));
  }
  matches.left_size = spec.left_camera.size;
  matches.right_size = spec.right_camera.size;
  matches.left_camera = spec.left_camera;
  matches.right_camera = spec.right_camera;
  return scene;
}

}  // namespace corrsel::core
