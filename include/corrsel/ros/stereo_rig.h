#pragma once

#include <image_geometry/pinhole_camera_model.h>
#include <sensor_msgs/CameraInfo.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <string>

namespace corrsel {

/// One camera of a rig: its calibration and what its images are.
struct RigCamera {
  sensor_msgs::CameraInfo info;
  bool rectified = false;  ///< images come undistorted and rectified
  std::string name;        ///< for errors, e.g. the topic of camera_info
};

/// The epipolar geometry of two cameras that were calibrated together (sensor_msgs/CameraInfo, REP 104).
/// Binning, region of interest and distortion are those of image_geometry: plumb_bob, rational_polynomial,
/// equidistant.
///
/// A calibration P = [M | p] sees a point X of the rectified frame at M X + p = M (X + t), t = M^-1 p. What
/// is x in the left and x' in the right rectified image obeys x'^T F x = 0 with F = M'^-T [t' - t]_x M^-1
/// (Hartley and Zisserman, Eq. 9.2, without rotation). No direction of the baseline and no equality of M and
/// M' is assumed.
class StereoRig {
 public:
  /// Throws std::invalid_argument naming the camera, what its calibration lacks and what to do: all zero, K
  /// without P, P without K where images are raw, R that is no rotation, a distortion model that
  /// image_geometry does not know, a baseline below a micrometre. Raw images cost the rectification maps.
  StereoRig(const RigCamera& left, const RigCamera& right);

  /// Between rectified images, px, Frobenius norm 1.
  const cv::Matx33d& fundamental() const { return fundamental_; }

  /// Distance of the cameras, m.
  double baseline() const { return baseline_; }

  /// The rectified image, of the same size and type: the image itself where the camera's images are rectified
  /// already, else undistorted, turned and interpolated linearly, black where nothing was seen. Throws
  /// std::invalid_argument where the image's size is not the one of camera_info.
  cv::Mat rectifyLeft(const cv::Mat& image) const { return left_.rectify(image); }
  cv::Mat rectifyRight(const cv::Mat& image) const { return right_.rectify(image); }

 private:
  class Camera {
   public:
    explicit Camera(const RigCamera& camera);
    cv::Mat rectify(const cv::Mat& image) const;
    const cv::Matx34d& projection() const { return model_.projectionMatrix(); }

   private:
    image_geometry::PinholeCameraModel model_;
    bool rectified_;
    cv::Size size_;
    std::string name_;
  };

  Camera left_, right_;
  cv::Matx33d fundamental_;
  double baseline_ = 0.0;
};

}  // namespace corrsel
