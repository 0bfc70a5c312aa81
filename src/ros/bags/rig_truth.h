#pragma once

#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/ground_truth.h"
#include "corrsel/image_pair.h"
#include "ros/bags/stereo_rig.h"

namespace corrsel {

/// The fundamental matrix of a rig as ground truth.
core::GroundTruth truthOf(const StereoRig& rig);

/// Two cameras whose raw images are used as they are.
struct RawRig {
  core::Camera left, right;
  core::GroundTruth truth;  ///< of their rays
};

/// The rig of raw images of which one at least is that of a fisheye lens, which a rectified image shows in
/// part only. Nothing of other images, and where camera_info does not tell the pose.
std::optional<RawRig> rawRigOf(const RigCamera& left, const RigCamera& right);

/// One side of matches, as points.
std::vector<cv::Point2f> pointsOf(const std::vector<float>& x, const std::vector<float>& y);

/// The other declarations of the images of a rig: both cameras "raw", or both "rectified". They serve to
/// notice that raw images were declared rectified or the other way round. A declaration that the calibration
/// does not allow is left out.
/// @param left, right  as given to the constructor of `rig`
/// Cost: the rectification maps, where the images were declared rectified.
std::vector<core::OtherReading> otherDeclarations(const RigCamera& left, const RigCamera& right,
                                                  const std::shared_ptr<const StereoRig>& rig);

}  // namespace corrsel
