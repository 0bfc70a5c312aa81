#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <string>

#include "corrsel/ros/cameras.h"

namespace corrsel {

/// The calibrations of both cameras of a rig.
struct RigCalibration {
  sensor_msgs::CameraInfo left, right;
};

/// The calibration of a rig for a corrected pose between its cameras: K, D and sizes as before, R and P of
/// new rectified images. They are computed as ROS's camera calibrator does: by OpenCV's stereoRectify() with
/// the principal points at one place and no pixel without an image (alpha = 0), or by its counterpart for
/// fisheye lenses.
/// @param rectified  whether the pose is that of the images rectified by the old calibration
/// Throws std::invalid_argument that names the field, as cameraOf() does, and for a distortion that
/// OpenCV does not know.
RigCalibration corrected(const RigCalibration& calibration, bool rectified, const RigPose& pose);

/// Writes left.yaml and right.yaml, which camera_info_manager reads, into a folder, which is made if it does
/// not exist. Each file is replaced at once. Throws std::runtime_error that names the file.
void writeCalibration(const RigCalibration& calibration, const std::string& folder);

}  // namespace corrsel
