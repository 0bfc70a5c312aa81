#pragma once

// Matches of a stereo rig that drives through a generated world.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/pose_result.h"
#include "corrsel/random.h"
#include "geometry/pose_fit.h"

namespace corrsel::core::rig_scene {

constexpr double kDegree = CV_PI / 180;
constexpr double kBaseline = 0.5;  // m

inline Camera camera() {
  Camera result;
  result.matrix = {700, 0, 619.5, 0, 700, 187.5, 0, 0, 1};
  result.size = {1240, 376};
  return result;
}

/// The calibrated pose of the rig: the right camera is kBaseline to the right.
inline Pose calibrated() {
  Pose pose;
  pose.translation = {-1, 0, 0};
  return pose;
}

/// The calibrated pose after a deviation in degrees.
inline Pose bent(const cv::Vec<double, 5>& degrees) { return moved(calibrated(), degrees * kDegree); }

struct DriveSpec {
  std::size_t points = 300;
  double rate = 10;          ///< pairs per second
  double fresh_noise = 0.3;  ///< of each coordinate of a feature in each image, px
  double own_noise = 0.2;    ///< of a point for as long as it is seen, px
  double common_noise = 0;   ///< of the rotation in each pair, degrees
  double wrong = 0.05;       ///< share of wrong matches
  bool objects = false;      ///< moving objects that come and go, seen by cameras that are not synchronous
  bool stops = false;        ///< stands still for some time now and then
  std::uint64_t seed = 1;
};

/// A drive of 10 m/s with turns. Points lie 3 to 80 m before the rig; one that leaves an image is replaced.
class Drive {
 public:
  explicit Drive(const DriveSpec& spec) : spec_(spec), random_(spec.seed), points_(spec.points) {
    for (Point& point : points_) place(point);
  }

  /// The matches of the next pair, with the true pose of the rig.
  Correspondences next(const Pose& rig) {
    advance();
    cv::Vec<double, 5> shake;
    for (int k = 0; k < 3; ++k) shake[k] = spec_.common_noise * kDegree * random_.normal();
    const Pose pose = moved(rig, shake);
    Correspondences matches;
    matches.left_camera = matches.right_camera = camera();
    matches.left_size = matches.right_size = camera().size;
    for (Point& point : points_) {
      cv::Point2d left, right;
      if (!see(point, pose, left, right)) continue;
      matches.add(disturbed(left, point.noise[0]), disturbed(right, point.noise[1]));
    }
    return matches;
  }

  double time() const { return time_; }

 private:
  struct Point {
    cv::Vec3d position;  // in the frame of the left camera, m
    std::array<cv::Point2d, 2> noise;
    bool wrong = false;
  };

  /// An object that moves beside the epipolar lines between the exposures of the cameras.
  struct Object {
    cv::Rect2d region;
    cv::Point2d offset;
    double until = 0;
  };

  void place(Point& point) {
    const double u = random_.uniform(0, camera().size.width);
    const double v = random_.uniform(0, camera().size.height);
    const double depth = 3 * std::pow(80.0 / 3, random_.uniform());
    Ray ray;
    unproject(camera(), {u, v}, ray);
    point.position = ray.direction * (depth / ray.direction[2]);
    for (cv::Point2d& noise : point.noise) {
      const double x = random_.normal();
      const double y = random_.normal();
      noise = cv::Point2d(x, y) * spec_.own_noise;
    }
    point.wrong = random_.uniform() < spec_.wrong;
  }

  void advance() {
    time_ += 1 / spec_.rate;
    if (spec_.stops && time_ >= change_) {
      stands_ = !stands_;
      change_ = time_ + random_.uniform(5, 30);
    }
    if (!stands_) {
      const double angle = 0.2 * std::sin(0.3 * time_) / spec_.rate, step = 10 / spec_.rate;
      const cv::Matx33d turn(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                             std::cos(angle));
      for (Point& point : points_) point.position = turn * point.position - cv::Vec3d(0, 0, step);
    }
    if (spec_.objects && time_ >= object_.until + 5) {
      const double width = random_.uniform(0.1, 0.4) * camera().size.width;
      const double x = random_.uniform(0, camera().size.width - width);
      const double dx = random_.uniform(-6, 6);
      const double dy = random_.uniform(-3, 3);
      object_ = {{x, 60, width, 300}, {dx, dy}, time_ + random_.uniform(2, 8)};
    }
  }

  /// Replaces a point that is not seen.
  bool see(Point& point, const Pose& pose, cv::Point2d& left, cv::Point2d& right) {
    const cv::Rect2d image(cv::Point2d(), cv::Size2d(camera().size));
    constexpr double kNearest = 2;
    const cv::Vec3d in_right = pose.rotation * point.position + kBaseline * pose.translation;
    if (point.position[2] < kNearest || !project(camera(), point.position, left) ||
        !project(camera(), in_right, right) || !image.contains(left) || !image.contains(right)) {
      place(point);
      return false;
    }
    if (point.wrong) right = {random_.uniform(0, image.width), random_.uniform(0, image.height)};
    if (spec_.objects && time_ < object_.until && object_.region.contains(left)) right += object_.offset;
    return true;
  }

  cv::Point2d disturbed(const cv::Point2d& point, const cv::Point2d& own) {
    const double x = random_.normal();
    const double y = random_.normal();
    return point + own + cv::Point2d(x, y) * spec_.fresh_noise;
  }

  DriveSpec spec_;
  Random random_;
  std::vector<Point> points_;
  double time_ = 0, change_ = 20;
  bool stands_ = false;
  Object object_;
};

}  // namespace corrsel::core::rig_scene
