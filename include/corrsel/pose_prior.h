#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "corrsel/pose_result.h"

namespace corrsel::core {

/// What is known of the motion between two calibrated images besides their matches, for example from an
/// inertial unit or from the calibration of a stereo rig. What is known is taken as exact: its error should
/// be small against a pixel.
struct PosePrior {
  enum class Kind : std::uint8_t {
    kRotation = 0,  ///< the rotation is known; two matches determine the direction of the translation
    kVertical = 1,  ///< one direction is known in both cameras; three matches determine the rest
    kRig = 2        ///< the pose is known; nothing is searched, and matches are judged by it
  };

  Kind kind = Kind::kRig;
  cv::Matx33d rotation = cv::Matx33d::eye();  ///< R of Pose; of kRotation and kRig
  cv::Vec3d translation;                      ///< t of Pose, of length 1; of kRig
  /// The same direction, for example that of gravity, in the frames of both cameras, of length 1; of
  /// kVertical.
  cv::Vec3d left_down, right_down;

  static PosePrior ofRotation(const cv::Matx33d& rotation);
  /// @param left_down, right_down  of any length above 0, such as accelerations at rest
  static PosePrior ofVertical(const cv::Vec3d& left_down, const cv::Vec3d& right_down);
  /// @param translation  of any length above 0, which may be the baseline in m
  static PosePrior ofRig(const cv::Matx33d& rotation, const cv::Vec3d& translation);

  /// Throws std::invalid_argument naming the member, its value and what is valid: numbers that are not
  /// finite, a matrix that differs from a rotation by more than 1e-4, and directions whose length differs
  /// from 1 by more than 1e-6.
  void check() const;
};

}  // namespace corrsel::core
