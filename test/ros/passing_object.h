#pragma once

#include <ros/time.h>

#include <cstddef>

#include "corrsel/random.h"
#include "corrsel/ros/conversions.h"

namespace corrsel::testing {

constexpr std::size_t kObjectMatches = 60, kSceneMatches = 300;

/// Matches of a camera at rest, of which the first kObjectMatches belong to an object that has passed by.
inline Correspondences passingObject(const ros::Time& stamp) {
  core::Random random(1);
  core::Correspondences matches;
  while (matches.size() < kObjectMatches + kSceneMatches) {
    const bool object = matches.size() < kObjectMatches;
    const double x = object ? random.uniform(200, 300) : random.uniform(0, 639);
    const double y = object ? random.uniform(150, 250) : random.uniform(0, 479);
    if (!object && x > 180 && x < 350 && y > 130 && y < 300) continue;
    const double dx = 0.5 * random.normal() + (object ? 30 : 0);
    const double dy = 0.5 * random.normal() + (object ? 20 : 0);
    matches.add(cv::Point2f(cv::Point2d(x, y)), cv::Point2f(cv::Point2d(x + dx, y + dy)));
  }
  matches.left_size = matches.right_size = {640, 480};
  PairInfo info;
  info.header.stamp = info.right_stamp = stamp;
  info.header.frame_id = "left_optical";
  info.features = "given";
  return toMsg(matches, info);
}

}  // namespace corrsel::testing
