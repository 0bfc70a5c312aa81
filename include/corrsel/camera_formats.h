#pragma once

#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "corrsel/camera.h"

namespace corrsel::core {

// Cameras as other software writes them. The functions take names and numbers that were read already. All of
// them throw std::invalid_argument naming what a camera of the other kind has, or does not have, and what is
// valid. Cameras that are returned have passed Camera::check().

/// A pinhole of OpenCV's module calib3d.
/// @param distortion  none, or k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]], of which thin prism and
///                    tilt must be 0
Camera cameraFromOpenCv(const cv::Matx33d& matrix, const std::vector<double>& distortion,
                        const cv::Size& size = {});

/// A camera of OpenCV's module cv::fisheye.
/// @param distortion  none, or k1 k2 k3 k4
Camera cameraFromOpenCvFisheye(const cv::Matx33d& matrix, const std::vector<double>& distortion,
                               const cv::Size& size = {});

/// Distortion as OpenCV's functions take it beside Camera::matrix: k1 k2 p1 p2 k3 of a pinhole (for
/// cv::undistortPoints() etc.), the same and k4 k5 k6 where one of them is not 0, and k1 k2 k3 k4 of a
/// fisheye lens (for cv::fisheye::undistortPoints() etc.). These two functions ignore a skew. OpenCV has no
/// panoramas.
std::vector<double> openCvDistortion(const Camera& camera);

/// What sensor_msgs/CameraInfo of ROS says about the original image, whatever its rectification, binning and
/// region of interest are.
struct CameraInfoFields {
  cv::Size size;                 ///< width and height
  std::string distortion_model;  ///< plumb_bob, rational_polynomial, equidistant (or fisheye)
  std::vector<double> d;         ///< as in cameraFromOpenCv() or cameraFromOpenCvFisheye()
  cv::Matx33d k;
};

/// An empty distortion_model is a pinhole and must come with coefficients that are 0.
Camera cameraFromInfo(const CameraInfoFields& info);
CameraInfoFields cameraToInfo(const Camera& camera);

/// A camera of COLMAP's models, with its names and the order of its parameters.
struct ColmapCamera {
  /// SIMPLE_PINHOLE (f cx cy), PINHOLE (fx fy cx cy), SIMPLE_RADIAL (f cx cy k), RADIAL (f cx cy k1 k2),
  /// OPENCV (fx fy cx cy k1 k2 p1 p2), FULL_OPENCV (the same and k3 k4 k5 k6), OPENCV_FISHEYE (fx fy cx cy k1
  /// k2 k3 k4), SIMPLE_RADIAL_FISHEYE (f cx cy k) or RADIAL_FISHEYE (f cx cy k1 k2)
  std::string model;
  cv::Size size;
  std::vector<double> parameters;  ///< px, with the centre of the first pixel at (0.5, 0.5), and coefficients
};

/// Principal points are shifted by half a pixel, because here the first pixel's centre is (0, 0).
Camera cameraFromColmap(const ColmapCamera& colmap);

/// The result's model is PINHOLE, OPENCV, FULL_OPENCV or OPENCV_FISHEYE, none of which has a skew.
ColmapCamera cameraToColmap(const Camera& camera);

/// A camera in Kalibr's yaml files, and in those of EuRoC.
struct KalibrCamera {
  std::string camera_model;               ///< pinhole
  std::vector<double> intrinsics;         ///< fu fv pu pv, px
  std::string distortion_model;           ///< radtan (or radial-tangential), equidistant (or equi), none
  std::vector<double> distortion_coeffs;  ///< k1 k2 p1 p2 of radtan, k1 k2 k3 k4 of equidistant
  cv::Size resolution;
};

Camera cameraFromKalibr(const KalibrCamera& kalibr);
KalibrCamera cameraToKalibr(const Camera& camera);

}  // namespace corrsel::core
