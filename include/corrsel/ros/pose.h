#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>

#include <optional>
#include <string>

#include "corrsel/RelativePose.h"
#include "corrsel/pose_result.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/selection.h"

namespace corrsel {

/// Variance of what is not known in the messages of poseOfRight(): m^2 for positions, rad^2 for rotations.
constexpr double kUnknownVariance = 1e6;

/// Converts the pose of a selection to a message. Where the pair is of a calibrated rig (PairInfo::rig),
/// nothing is estimated that is known: rotation, translation and scale are those of the rig, and the
/// covariance is 0.
/// @pre selection.pose
/// @param selector  name, with the preset where one was given, e.g. "pose"
RelativePose toPoseMsg(const core::Selection& selection, const PairInfo& info, const std::string& selector);

/// Converts a message to a pose, which of a calibrated rig is the rig's.
/// @param info      header, right stamp, right frame and rig are filled where it is not null
/// Throws std::invalid_argument that names the field if status or motion are unknown, if a rotation is no
/// unit quaternion, a translation neither of length 1 nor, where the motion has none, 0, or if noise,
/// parallax or scale are negative.
core::PoseResult fromMsg(const RelativePose& msg, PairInfo* info = nullptr);

/// The pose of the right camera in the frame of the left one, for rviz and filters: the inverse of
/// RelativePose, with position -R^T t and orientation R^T. The position has length 1 where the scale is
/// unknown. The covariance is in ROS's order: position, then rotation about the fixed axes of the left frame.
///
/// What is unknown has a variance of kUnknownVariance: the length of the translation where the scale is
/// unknown; the whole position at rest and of a rotation; everything where the covariance is NaN, and where
/// there is a second pose, since either of the two may be the true one.
///
/// @return nothing at MOTION_NONE, and where the status is neither STATUS_OK nor STATUS_TIME_LIMIT. Throws as
/// fromMsg() does.
///
/// Derivation: with the errors of RelativePose, exp([w]x) R and t + B (a, b), the true orientation is
/// exp([-R^T w]x) R^T, and the true position is -R^T (t + B (a, b) + [t]x w), both to first order.
std::optional<geometry_msgs::PoseWithCovarianceStamped> poseOfRight(const RelativePose& msg);

}  // namespace corrsel
