#pragma once

#include <image_geometry/pinhole_camera_model.h>
#include <sensor_msgs/CameraInfo.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <string>
#include <vector>

#include "corrsel/relative_pose.h"

namespace corrsel {

/// One camera of a rig: its calibration and the kind of its images.
struct RigCamera {
  sensor_msgs::CameraInfo info;
  bool rectified = false;  ///< the images are already undistorted and rectified
  std::string name;        ///< for error texts, e.g. the topic of camera_info
};

/// The epipolar geometry of two cameras that were calibrated together (sensor_msgs/CameraInfo, REP 104).
///
/// Input: binning, region of interest and distortion as image_geometry supports them (plumb_bob,
/// rational_polynomial, equidistant).
///
/// Areas: raw images are rectified and then cut to the largest rectangle without the black area that no
/// camera pixel maps to, since its edge would produce features that do not exist in the scene. Two cameras
/// with images of one size get the same rectangle, so that rows stay aligned.
///
/// Equations: a calibration P = [M | p] projects a point X of the rectified frame to M X + p = M (X + t),
/// t = M^-1 p. A point at x in the left and x' in the right rectified image fulfils x'^T F x = 0 with
/// F = M'^-T [t' - t]_x M^-1. Neither a direction of the baseline nor M = M' is assumed.
///
/// Source: Hartley and Zisserman, Multiple View Geometry, Eq. 9.2, without rotation.
class StereoRig {
 public:
  /// Throws std::invalid_argument that names the camera, the defect of its calibration and the remedy: all
  /// zero, K without P, P without K for raw images, an R that is not a rotation, a distortion model that
  /// image_geometry does not know, or a baseline below a micrometre. Cost: the rectification maps for raw
  /// images.
  StereoRig(const RigCamera& left, const RigCamera& right);

  /// The fundamental matrix between the images that rectifyLeft() and rectifyRight() return, px, Frobenius
  /// norm 1.
  const cv::Matx33d& fundamental() const { return fundamental_; }

  /// Calibration of these images, and the pose of the right camera: no rotation, and the translation of P in
  /// m.
  const core::RelativePose& pose() const { return pose_; }

  /// Distance of the cameras, m.
  double baseline() const { return cv::norm(pose_.translation); }

  /// Returns the image itself if the camera's images are rectified already. Otherwise the image is
  /// undistorted, rotated, interpolated linearly and cut to its area. Throws std::invalid_argument if the
  /// size of the image is not that of camera_info.
  cv::Mat rectifyLeft(const cv::Mat& image) const { return left_.rectify(image); }
  cv::Mat rectifyRight(const cv::Mat& image) const { return right_.rectify(image); }

  /// Maps points of a camera's images, px, to the image that rectifyLeft() or rectifyRight() returns. Column
  /// 3 is the position, px; columns 1 and 2 are its derivatives by x and y (central differences). The result
  /// is NaN where the lens cannot be inverted and beyond the area that is kept. Points of rectified images do
  /// not move.
  std::vector<cv::Matx23d> rectifyLeft(const std::vector<cv::Point2f>& points) const {
    return left_.rectify(points);
  }
  std::vector<cv::Matx23d> rectifyRight(const std::vector<cv::Point2f>& points) const {
    return right_.rectify(points);
  }

  /// The positions alone, which takes a fifth of the time.
  std::vector<cv::Point2f> positionsLeft(const std::vector<cv::Point2f>& points) const {
    return left_.positions(points);
  }
  std::vector<cv::Point2f> positionsRight(const std::vector<cv::Point2f>& points) const {
    return right_.positions(points);
  }

  /// The inverse of rectifyLeft() and rectifyRight() for points: px of the rectified image to px of the
  /// camera's image, which may lie outside of it.
  std::vector<cv::Point2f> recordedLeft(const std::vector<cv::Point2f>& points) const {
    return left_.recorded(points);
  }
  std::vector<cv::Point2f> recordedRight(const std::vector<cv::Point2f>& points) const {
    return right_.recorded(points);
  }

  /// Size of the cameras' images, px.
  const cv::Size& leftSize() const { return left_.size; }
  const cv::Size& rightSize() const { return right_.size; }

  /// The part of the rectified image, as P describes it, that is kept, px.
  const cv::Rect& leftArea() const { return left_.area; }
  const cv::Rect& rightArea() const { return right_.area; }

 private:
  struct Camera {
    explicit Camera(const RigCamera& camera);
    cv::Mat rectify(const cv::Mat& image) const;
    std::vector<cv::Matx23d> rectify(const std::vector<cv::Point2f>& points) const;
    std::vector<cv::Point2f> positions(const std::vector<cv::Point2f>& points) const;
    std::vector<cv::Point2d> kept(const std::vector<cv::Point2d>& points,
                                  const std::vector<cv::Point2d>& whole) const;
    std::vector<cv::Point2f> recorded(const std::vector<cv::Point2f>& points) const;
    std::vector<cv::Point2d> undistorted(const std::vector<cv::Point2d>& points) const;
    std::vector<cv::Point2d> distorted(const std::vector<cv::Point2d>& points) const;
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
  core::RelativePose pose_;
  cv::Matx33d fundamental_;
};

}  // namespace corrsel
