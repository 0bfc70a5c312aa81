#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace corrsel::core {

/// A calibrated camera: how points in front of it (x to the right, y down, z forward) are imaged. Images need
/// not be rectified. Models:
///  - kPinhole with OpenCV's radial and tangential distortion k1 k2 p1 p2 k3 and the denominator k4 k5 k6 of
///    its rational model (calib3d, cv::projectPoints);
///  - kFisheye: Kannala and Brandt, PAMI 2006, with k1 k2 k3 k4 (OpenCV's fisheye module, "equidistant" in
///    ROS and Kalibr);
///  - kEquirectangular: a panorama of 360 by 180 degrees that fills an image of `size`; it has no other
///    parameters.
struct Camera {
  enum class Model : std::uint8_t { kPinhole = 0, kFisheye = 1, kEquirectangular = 2 };

  Model model = Model::kPinhole;
  cv::Matx33d matrix = cv::Matx33d::eye();  ///< K, px: [fx s cx; 0 fy cy; 0 0 1]; not of a panorama
  /// Distortion: k1 k2 p1 p2 k3 k4 k5 k6 of a pinhole (OpenCV's order), k1 k2 k3 k4 of a fisheye lens; the
  /// others are 0.
  std::array<double, 8> distortion{};
  cv::Size size;  ///< of the images, px; 0x0 if unknown, which a panorama does not allow

  /// Throws std::invalid_argument naming the member, its value and what is valid: numbers that are not
  /// finite, a matrix of another form or without positive focal lengths, coefficients that the model does not
  /// have, and a panorama without a size.
  void check() const;

  /// Whether the camera is a pinhole without distortion.
  bool isPlainPinhole() const;

  /// The camera of the image after it was scaled, with pixel centres at whole numbers: u' = s (u + 0.5) -
  /// 0.5.
  Camera scaled(double factor) const;
};

bool operator==(const Camera& a, const Camera& b);
inline bool operator!=(const Camera& a, const Camera& b) { return !(a == b); }

/// "pinhole", "fisheye" or "equirectangular"; part of the file formats.
std::string toString(Camera::Model model);

/// Throws std::invalid_argument listing the valid texts.
Camera::Model cameraModelFromString(const std::string& text);

/// The unit ray of a pixel, and its derivative by the pixel's coordinates, 1/px.
struct Ray {
  cv::Vec3d direction;
  cv::Matx<double, 3, 2> jacobian;
};

/// Computes the ray of a pixel. @return false where the model has no inverse, for example beyond the turning
/// point of a distortion polynomial, and for coordinates that are not finite
bool unproject(const Camera& camera, const cv::Point2d& pixel, Ray& ray);

/// Computes the pixel in which a point is seen. @return false where it is not seen: behind a pinhole, beyond
/// the turning point of the distortion
bool project(const Camera& camera, const cv::Vec3d& point, cv::Point2d& pixel);

}  // namespace corrsel::core
