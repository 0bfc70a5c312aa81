#pragma once

#include <opencv2/core/matx.hpp>

namespace corrsel::core {

/// Calibration of both images of a pair, and the pose of the right camera relative to the left one: a point X
/// in the frame of the left camera is R X + t in that of the right one. Camera frames are optical frames (x
/// to the right, y down, z forward). Lens distortion is not part of it: either the images are undistorted, or
/// the cameras of the pair (ImagePair) tell how they are distorted, and those of this struct are the pinholes
/// through which estimators that know only pinholes see the matches, see evaluation/pinhole_view.h.
struct RelativePose {
  cv::Matx33d left_camera = cv::Matx33d::eye();   ///< K, px: [fx s cx; 0 fy cy; 0 0 1]
  cv::Matx33d right_camera = cv::Matx33d::eye();  ///< K', px
  cv::Matx33d rotation = cv::Matx33d::eye();      ///< R
  cv::Vec3d translation;                          ///< t, in any unit; zero where the camera only turned

  /// Throws std::invalid_argument naming the member, its value and what is valid: numbers that are not
  /// finite, a camera matrix of another form or without positive focal lengths, an R that is not a rotation
  /// (to 1e-4).
  void check() const;

  /// F = K'^-T [t]_x R K^-1, px, with Frobenius norm 1 (Hartley and Zisserman, Multiple View Geometry,
  /// Eq. 9.12). Throws std::invalid_argument where t is zero.
  cv::Matx33d fundamental() const;
};

}  // namespace corrsel::core
