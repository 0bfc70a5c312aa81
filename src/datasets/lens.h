#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <string>

#include "corrsel/camera.h"

namespace corrsel::core {

/// A calibrated camera, and what removes the distortion of its lens from images, so that they are those of a
/// pinhole. The images of fisheye lenses and panoramas are not touched, because a pinhole would show a small
/// part of them. Those of cameras without distortion are not touched either.
///
/// The undistorted image has the size of the original one. Its camera matrix is chosen so that it shows no
/// place beyond the original image, and hence has no border without content: cv::getOptimalNewCameraMatrix
/// with alpha = 0, enlarged in steps of half a percent until the border is inside. Pixels are interpolated
/// linearly.
class Lens {
 public:
  /// @param name    of the camera, for error texts
  /// @param camera  of the images; its size may be empty (then unknown) where there is no distortion
  /// Throws std::invalid_argument for a camera that Camera::check() refuses, a principal point outside the
  /// image, and a distortion that cannot be removed.
  Lens(const std::string& name, const Camera& camera);

  /// The camera of the images that undistorted() returns.
  const Camera& camera() const { return camera_; }

  /// Whether undistorted() changes images.
  bool distorted() const { return camera_ != original_; }

  /// Throws std::invalid_argument where the image has another size, or does not contain the principal point.
  cv::Mat undistorted(const cv::Mat& image) const;

  /// For a remark on what was done to the images; only for a lens with distortion.
  std::string text() const;

 private:
  double beyondBorder() const;

  std::string name_;
  Camera original_, camera_;
};

/// The size of images as a calibration states it, px. Throws std::invalid_argument for one that OpenCV does
/// not read, or that is not whole.
cv::Size imageSize(double width, double height);

/// [fx 0 cx; 0 fy cy; 0 0 1]
inline cv::Matx33d cameraMatrix(double fx, double fy, double cx, double cy) {
  return {fx, 0, cx, 0, fy, cy, 0, 0, 1};
}

}  // namespace corrsel::core
