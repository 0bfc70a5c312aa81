#pragma once

// Matches of two calibrated images with a known pose.

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "cameras.h"
#include "corrsel/camera.h"
#include "corrsel/pose_result.h"
#include "corrsel/random.h"
#include "geometry/pose_fit.h"
#include "geometry/rays.h"

namespace corrsel::core::pose_scene {

inline Camera pinhole() {
  Camera camera;
  camera.matrix = {600, 0, 639.5, 0, 600, 479.5, 0, 0, 1};
  camera.size = {1280, 960};
  return camera;
}

inline Camera fisheye() { return testing::fisheyeCamera(); }

inline Camera panorama() {
  Camera camera;
  camera.model = Camera::Model::kEquirectangular;
  camera.size = {1280, 640};
  return camera;
}

inline std::array<Camera, 3> cameras() { return {pinhole(), fisheye(), panorama()}; }

inline void append(const Ray& ray, Rays& rays) {
  for (int k = 0; k < 3; ++k) rays.column[static_cast<std::size_t>(k)].push_back(ray.direction[k]);
  for (int k = 0; k < 6; ++k) rays.column[static_cast<std::size_t>(3 + k)].push_back(ray.jacobian.val[k]);
}

/// Appends a match, if both of its rays exist.
inline bool append(const Camera& camera, const cv::Point2d& left, const cv::Point2d& right,
                   RayMatches& matches) {
  Ray left_ray, right_ray;
  if (!unproject(camera, left, left_ray) || !unproject(camera, right, right_ray)) return false;
  append(left_ray, matches.left);
  append(right_ray, matches.right);
  return true;
}

inline cv::Vec3d randomDirection(Random& random) {
  cv::Vec3d v;
  for (int k = 0; k < 3; ++k) v[k] = random.normal();
  return cv::normalize(v);
}

/// A rotation of 2 to 15 degrees and a translation, both about and along random directions.
inline Pose randomPose(Random& random) {
  const cv::Vec3d axis = randomDirection(random);
  const double angle = random.uniform(2, 15) * CV_PI / 180;
  const cv::Vec3d w = axis * angle, t = randomDirection(random);
  return moved({cv::Matx33d::eye(), t}, {w[0], w[1], w[2], 0, 0});
}

inline cv::Point2d noisy(const cv::Point2d& point, double noise, Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  return {point.x + noise * x, point.y + noise * y};
}

/// Right matches only: left pixels uniform in the image, depths of 4 to 12 in units in which the baseline is
/// `baseline`, noise in px on all coordinates.
inline RayMatches generated(const Camera& camera, const Pose& pose, double baseline, double noise,
                            std::size_t size, Random& random) {
  RayMatches matches;
  while (matches.size() < size) {
    const double u = random.uniform(0, camera.size.width);
    const double v = random.uniform(0, camera.size.height);
    const double depth = random.uniform(4, 12);
    Ray ray;
    cv::Point2d right;
    if (!unproject(camera, {u, v}, ray)) continue;
    const cv::Vec3d moved_point = pose.rotation * (ray.direction * depth) + pose.translation * baseline;
    if (!project(camera, moved_point, right)) continue;
    if (!cv::Rect2d(cv::Point2d(), cv::Size2d(camera.size)).contains(right)) continue;
    const cv::Point2d noisy_left = noisy({u, v}, noise, random);
    const cv::Point2d noisy_right = noisy(right, noise, random);
    append(camera, noisy_left, noisy_right, matches);
  }
  return matches;
}

// An example that was computed independently, with 12 digits.

inline Pose examplePose() {
  const cv::Vec3d t = cv::normalize(cv::Vec3d(1, 0.5, -0.25));
  return moved({cv::Matx33d::eye(), t}, {0.10, -0.20, 0.05, 0, 0});
}

inline Camera exampleCamera() {
  Camera camera;
  camera.matrix = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  camera.size = {640, 480};
  return camera;
}

inline const std::array<cv::Vec3d, 8>& examplePoints() {
  static const std::array<cv::Vec3d, 8> points = {{{-1, -0.5, 4},
                                                   {1.2, 0.4, 5},
                                                   {0.3, -1.1, 6},
                                                   {-0.7, 0.9, 3.5},
                                                   {0.5, 0.6, 4.5},
                                                   {-1.5, -1.2, 7},
                                                   {1.8, -0.9, 5.5},
                                                   {0.1, 0.2, 8}}};
  return points;
}

/// The matches of the example's points.
/// @param noise  1: with the offsets of the example, 0: exact
inline RayMatches exampleMatches(double noise) {
  constexpr double kOffsets[8][4] = {{.3, -.2, .1, .4},   {-.5, .1, .2, -.3}, {.2, .2, -.4, .1},
                                     {-.1, .5, .3, -.2},  {.4, -.4, -.1, .2}, {-.3, .1, .5, .3},
                                     {.1, -.3, -.2, -.5}, {0, .2, .1, -.1}};
  const Pose pose = examplePose();
  RayMatches matches;
  for (std::size_t i = 0; i < 8; ++i) {
    cv::Point2d left, right;
    project(exampleCamera(), examplePoints()[i], left);
    project(exampleCamera(), pose.rotation * examplePoints()[i] + pose.translation, right);
    const double(&offset)[4] = kOffsets[i];
    append(exampleCamera(), left + cv::Point2d(offset[0], offset[1]) * noise,
           right + cv::Point2d(offset[2], offset[3]) * noise, matches);
  }
  return matches;
}

/// The angle between two directions, rad.
inline double angleBetween(const cv::Vec3d& a, const cv::Vec3d& b) {
  return std::atan2(cv::norm(a.cross(b)), a.dot(b));
}

}  // namespace corrsel::core::pose_scene
