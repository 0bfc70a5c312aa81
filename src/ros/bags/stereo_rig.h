#pragma once

#include <image_geometry/pinhole_camera_model.h>
#include <sensor_msgs/CameraInfo.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <string>
#include <vector>

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
/// Rectified raw images are cut to the largest rectangle that holds nothing but what the camera saw; of two
/// cameras with images of one size, to one that does so for both, which keeps rows aligned. The edge of the
/// black beyond would give features that are in no scene.
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

  /// Between the images that rectifyLeft() and rectifyRight() give, px, Frobenius norm 1.
  const cv::Matx33d& fundamental() const { return fundamental_; }

  /// Distance of the cameras, m.
  double baseline() const { return baseline_; }

  /// The image itself where the camera's images are rectified already, else undistorted, turned, interpolated
  /// linearly and cut to its area. Throws std::invalid_argument where the image's size is not the one of
  /// camera_info.
  cv::Mat rectifyLeft(const cv::Mat& image) const { return left_.rectify(image); }
  cv::Mat rectifyRight(const cv::Mat& image) const { return right_.rectify(image); }

  /// Where points of a camera's images, px, are in the image that rectifyLeft() or rectifyRight() gives, and
  /// how their surroundings are mapped: column 3 is the position, px, columns 1 and 2 are its derivative by x
  /// and y (central differences). NaN where the lens cannot be inverted, and beyond the area that is kept. Of
  /// rectified images, points stay where they are.
  std::vector<cv::Matx23d> rectifyLeft(const std::vector<cv::Point2f>& points) const {
    return left_.rectify(points);
  }
  std::vector<cv::Matx23d> rectifyRight(const std::vector<cv::Point2f>& points) const {
    return right_.rectify(points);
  }

  /// Size of the cameras' images, px.
  const cv::Size& leftSize() const { return left_.size; }
  const cv::Size& rightSize() const { return right_.size; }

  /// What is kept of the rectified image, which P describes, px.
  const cv::Rect& leftArea() const { return left_.area; }
  const cv::Rect& rightArea() const { return right_.area; }

 private:
  struct Camera {
    explicit Camera(const RigCamera& camera);
    cv::Mat rectify(const cv::Mat& image) const;
    std::vector<cv::Matx23d> rectify(const std::vector<cv::Point2f>& points) const;
    std::vector<cv::Point2d> undistorted(const std::vector<cv::Point2d>& points) const;
    cv::Mat rectifyWhole(const cv::Mat& image) const;
    cv::Mat seen() const;
    cv::Matx33d ray() const;
    cv::Vec3d translation() const;

    image_geometry::PinholeCameraModel model;
    bool rectified;
    cv::Size size;  ///< of the camera's images
    cv::Rect area;
    std::string name;
  };
  void chooseAreas();

  Camera left_, right_;
  cv::Matx33d fundamental_;
  double baseline_ = 0.0;
};

}  // namespace corrsel
