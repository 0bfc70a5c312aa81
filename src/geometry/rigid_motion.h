#pragma once

#include <opencv2/core/matx.hpp>

namespace corrsel::core {

/// The motion X -> R X + t.
struct RigidMotion {
  cv::Matx33d rotation = cv::Matx33d::eye();  ///< R
  cv::Vec3d translation;                      ///< t

  RigidMotion inverse() const;

  /// First `second`, then `first`.
  friend RigidMotion operator*(const RigidMotion& first, const RigidMotion& second);
};

/// The motion of a quaternion and a translation. The quaternion need not have length 1. Throws
/// std::invalid_argument where its length is zero, or a number is not finite.
RigidMotion motionOf(double w, double x, double y, double z, const cv::Vec3d& translation);

/// The motion of a matrix [R t; 0 0 0 1] that was written with few digits: R becomes the nearest rotation.
/// Throws std::invalid_argument where the last row is another one, where R is farther than 1e-2 from a
/// rotation (Frobenius norm of the difference), or where t is not finite.
RigidMotion motionOf(const cv::Matx44d& matrix);

/// The motion at the share (0 to 1) of the way from one to another one: the translation is interpolated
/// linearly, the rotation about a fixed axis with constant speed (Shoemake, Animating rotation with
/// quaternion curves, 1985).
RigidMotion interpolated(const RigidMotion& from, const RigidMotion& to, double share);

}  // namespace corrsel::core
