#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>

#include "corrsel/Camera.h"
#include "corrsel/camera.h"

namespace corrsel {

/// The pose of the right camera of a rig that was calibrated as a whole: a point X in the frame of the left
/// camera is rotation * X + translation in that of the right one. The frames are those in which the pixels of
/// the matches are: of the rectified images where the images are rectified.
struct RigPose {
  cv::Matx33d rotation = cv::Matx33d::eye();
  cv::Vec3d translation;  ///< m, not 0
};

/// Whether images are rectified, as a parameter declares them.
/// @param images  "raw", "rectified", or "auto": rectified if the name of their topic contains "image_rect"
bool isRectified(const std::string& images, const std::string& topic);

/// Whether a matrix is a rotation: R R^T = I to 1e-3, the accuracy of calibrations that were written as text.
bool isRotation(const cv::Matx33d& matrix);

/// The camera of the images to which a camera_info belongs (REP 104). Binning and the region of interest are
/// taken into account as image_geometry does. Raw images have K, and D with the models of
/// core::cameraFromInfo(); without distortion the model may have any name. Rectified images have the first
/// three columns of P.
/// @param rectified  whether the images are rectified
/// Throws std::invalid_argument that names the field, its value and the remedy: K (or P) is all zero, which
/// means that the camera is not calibrated, numbers that are not finite, focal lengths that are not positive,
/// an image size of zero, a region or a binning that does not fit into it, and what core::cameraFromInfo()
/// refuses.
core::Camera cameraOf(const sensor_msgs::CameraInfo& info, bool rectified);

/// The camera_info of a camera's images, which are raw: K, D and the size of the camera, R = I and P = [K 0],
/// with the model of core::cameraToInfo(), which throws for a panorama.
sensor_msgs::CameraInfo cameraInfo(const core::Camera& camera);

/// What the camera_info of two cameras tell about the pose between them (REP 104): R and P of cameras that
/// were calibrated together map to one rectified frame. Nothing where a P or, for raw images, an R is
/// missing, and where the cameras are less than a micrometre apart, as those of two calibrations of single
/// cameras.
/// @param left_rectified, right_rectified  whether the images are rectified
/// Source: Hartley and Zisserman, Multiple View Geometry, 2nd ed., Eq. 6.11 (P = M [I | M^-1 p]).
std::optional<RigPose> rigOf(const sensor_msgs::CameraInfo& left, bool left_rectified,
                             const sensor_msgs::CameraInfo& right, bool right_rectified);

/// Converts a camera to a message; MODEL_UNKNOWN where there is none.
Camera toMsg(const std::optional<core::Camera>& camera);

/// Converts a message to a camera; none where the model is MODEL_UNKNOWN.
/// Throws std::invalid_argument that names the field if the model is unknown, the image is larger than any
/// can be, or the camera is none (core::Camera::check()).
std::optional<core::Camera> fromMsg(const Camera& msg);

}  // namespace corrsel
