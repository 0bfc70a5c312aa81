#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace corrsel::core {

/// A calibrated camera, and what removes the distortion of its lens from images.
///
/// The undistorted image has the size of the original one. Its camera matrix is chosen so that it shows no
/// place beyond the original image, and hence has no border without content: cv::getOptimalNewCameraMatrix
/// with alpha = 0, enlarged in steps of half a percent until the border is inside. Pixels are interpolated
/// linearly. Images of a camera without distortion are not touched.
class Lens {
 public:
  /// @param name        of the camera, for error texts
  /// @param camera      K, px
  /// @param distortion  OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6]], or none
  /// @param size        of the images, px; may be empty (then unknown) where there is no distortion
  /// Throws std::invalid_argument for numbers that are not finite, focal lengths that are not positive, a
  /// principal point outside the image, and a distortion that cannot be removed.
  Lens(const std::string& name, const cv::Matx33d& camera, const std::vector<double>& distortion,
       const cv::Size& size);

  /// K of the undistorted image, px.
  const cv::Matx33d& camera() const { return camera_; }

  bool distorted() const { return !distortion_.empty(); }

  /// Throws std::invalid_argument where the image has another size, or does not contain the principal point.
  cv::Mat undistorted(const cv::Mat& image) const;

  /// For a remark on what was done to the images; only for a lens with distortion.
  std::string text() const;

 private:
  double beyondBorder() const;

  std::string name_;
  cv::Matx33d original_, camera_;
  std::vector<double> distortion_;
  cv::Size size_;
};

/// The size of images as a calibration states it, px. Throws std::invalid_argument for one that OpenCV does
/// not read, or that is not whole.
cv::Size imageSize(double width, double height);

/// [fx 0 cx; 0 fy cy; 0 0 1]
inline cv::Matx33d cameraMatrix(double fx, double fy, double cx, double cy) {
  return {fx, 0, cx, 0, fy, cy, 0, 0, 1};
}

}  // namespace corrsel::core
