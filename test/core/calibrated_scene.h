#pragma once

// Generated scenes for tests of calibrated selection: correspondences with cameras, inliers of a known motion
// and outliers.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/pose_result.h"
#include "corrsel/random.h"
#include "pose_scene.h"

namespace corrsel::core::calibrated_scene {

/// How the camera moves, and what it sees. All but kRest also turn by 2 to 15 degrees about a random axis.
enum class Scenario {
  kRest,
  kRotation,
  kGeneral,  ///< moves in a random direction
  kForward,  ///< moves along the left camera's axis
  kPlane     ///< moves in a random direction before a plane; with a baseline of 0 it turns only
};

struct SceneOptions {
  Scenario scenario = Scenario::kGeneral;
  Camera camera = pose_scene::pinhole();  ///< of both images
  std::size_t size = 300;                 ///< number of matches
  double right_share = 0.5;               ///< share of inliers
  double noise = 1;                       ///< standard deviation in both images, px
  double baseline = 0.2;                  ///< length of the translation over the mean depth
  bool has_distances = false;             ///< descriptor distances, mostly better for inliers
};

struct Scene {
  Correspondences matches;
  Pose truth;                        ///< t has length 1, or 0 where the camera does not move
  std::vector<std::uint8_t> inlier;  ///< not 0 for inliers
};

/// Depth along the ray of a pixel: uniform in 4 to 12, or that of a plane at distance 8 with normal
/// (0.4 N, 0.4 N, -1), at most 40. NaN where the ray does not meet the plane.
inline double sceneDepth(bool plane, const cv::Vec3d& normal, const cv::Vec3d& ray, Random& random) {
  constexpr double kDistance = 8, kMaxDepth = 40;
  if (!plane) return random.uniform(4, 12);
  const double depth = normal.dot({0, 0, kDistance}) / normal.dot(ray);
  return depth > 0 && depth <= kMaxDepth ? depth : std::nan("");
}

/// The motion of a scenario.
inline Pose scenePose(const SceneOptions& options, Random& random) {
  if (options.scenario == Scenario::kRest) return {};
  Pose pose = pose_scene::randomPose(random);
  if (options.scenario == Scenario::kForward) pose.translation = pose.rotation * cv::Vec3d(0, 0, -1);
  if (options.scenario == Scenario::kRotation || !(options.baseline > 0)) pose.translation = {};
  return pose;
}

inline cv::Point2d uniformPixel(const cv::Size& size, Random& random) {
  const double u = random.uniform(0, size.width);
  const double v = random.uniform(0, size.height);
  return {u, v};
}

/// A pixel that has a ray.
inline cv::Point2d visiblePixel(const Camera& camera, Random& random, Ray& ray) {
  cv::Point2d pixel = uniformPixel(camera.size, random);
  while (!unproject(camera, pixel, ray)) pixel = uniformPixel(camera.size, random);
  return pixel;
}

/// Appends a match, and its distances where they are wanted.
inline void append(const SceneOptions& options, const cv::Point2d& left, const cv::Point2d& right,
                   bool inlier, Random& random, Scene& scene) {
  scene.matches.left_x.push_back(static_cast<float>(left.x));
  scene.matches.left_y.push_back(static_cast<float>(left.y));
  scene.matches.right_x.push_back(static_cast<float>(right.x));
  scene.matches.right_y.push_back(static_cast<float>(right.y));
  scene.inlier.push_back(inlier ? 1 : 0);
  if (!options.has_distances) return;
  const double ratio = inlier ? random.uniform(0.3, 0.95) : random.uniform(0.6, 1);
  scene.matches.distance.push_back(static_cast<float>(ratio));
  scene.matches.second_distance.push_back(1);
}

/// Generates a scene: left pixels uniform in the image, right pixels of outliers, too. Inliers are visible in
/// both images before the noise is added. Inliers and outliers are in random order.
inline Scene generate(const SceneOptions& options, std::uint64_t seed) {
  constexpr double kMeanDepth = 8;
  Random random(seed);
  Scene scene;
  scene.matches.left_camera = scene.matches.right_camera = options.camera;
  scene.matches.left_size = scene.matches.right_size = options.camera.size;
  scene.truth = scenePose(options, random);
  const double tilt_x = random.normal();
  const double tilt_y = random.normal();
  const cv::Vec3d normal(0.4 * tilt_x, 0.4 * tilt_y, -1);
  const cv::Rect2d image(cv::Point2d(), cv::Size2d(options.camera.size));
  std::vector<std::uint32_t> order(options.size);
  for (std::uint32_t i = 0; i < options.size; ++i) order[i] = i;
  random.shuffle(order);
  const auto inliers =
      static_cast<std::uint32_t>(options.right_share * static_cast<double>(options.size) + 0.5);
  for (std::size_t i = 0; i < options.size;) {
    Ray ray, other;
    const cv::Point2d left = visiblePixel(options.camera, random, ray);
    cv::Point2d right;
    const bool inlier = order[i] < inliers;
    if (inlier) {
      const double depth = sceneDepth(options.scenario == Scenario::kPlane, normal, ray.direction, random);
      const cv::Vec3d point = scene.truth.rotation * (ray.direction * depth) +
                              scene.truth.translation * (options.baseline * kMeanDepth);
      if (std::isnan(depth) || !project(options.camera, point, right) || !image.contains(right)) continue;
    } else {
      right = visiblePixel(options.camera, random, other);
    }
    const cv::Point2d noisy_left = pose_scene::noisy(left, options.noise, random);
    const cv::Point2d noisy_right = pose_scene::noisy(right, options.noise, random);
    append(options, noisy_left, noisy_right, inlier, random, scene);
    ++i;
  }
  return scene;
}

}  // namespace corrsel::core::calibrated_scene
