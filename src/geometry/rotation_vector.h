#pragma once

#include <opencv2/core/matx.hpp>

namespace corrsel::core {

/// The rotation about the direction of w by its length, rad (Rodrigues).
cv::Matx33d rotationFromVector(const cv::Vec3d& w);

/// The reverse: the axis times the angle, rad, from 0 to pi.
cv::Vec3d rotationVector(const cv::Matx33d& rotation);

/// The rotation of a quaternion w x y z of any length but 0.
cv::Matx33d rotationFromQuaternion(const cv::Vec4d& q);

}  // namespace corrsel::core
