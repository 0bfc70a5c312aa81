#pragma once

#include <geometry_msgs/Vector3.h>

#include <opencv2/core/matx.hpp>

namespace corrsel {

inline geometry_msgs::Vector3 vectorMsg(const cv::Vec3d& v) {
  geometry_msgs::Vector3 msg;
  msg.x = v[0];
  msg.y = v[1];
  msg.z = v[2];
  return msg;
}

}  // namespace corrsel
