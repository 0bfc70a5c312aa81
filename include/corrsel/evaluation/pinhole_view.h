#pragma once

#include <opencv2/core/matx.hpp>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/relative_pose.h"

namespace corrsel::core {

/// Largest angle between a ray and the axis of the camera through which a pinhole sees it, degrees.
inline constexpr double kPinholeAngle = 80.0;

/// The pinhole in place of a camera whose images are not rectified: K of the camera itself; of a panorama,
/// the pinhole with as many pixels per radian at the centre of the image.
cv::Matx33d pinholeOf(const Camera& camera);

/// Matches as the pinholes of `pose` see them, for estimators that know only pinholes. The points of cameras
/// that are pinholes without distortion, or that are not known, stay where they are. The others become NaN
/// where they have no ray, or one that is more than kPinholeAngle from the axis. Frames are left out. O(N).
Correspondences throughPinholes(const Correspondences& matches, const RelativePose& pose);

}  // namespace corrsel::core
