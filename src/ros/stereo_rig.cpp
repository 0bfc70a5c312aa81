#include "corrsel/ros/stereo_rig.h"

#include <sensor_msgs/distortion_models.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "corrsel/text.h"

namespace corrsel {
namespace {

constexpr double kLeastBaseline = 1e-6;      // m
constexpr double kRotationTolerance = 1e-3;  // largest entry of R R^T - I
// Moves no pixel: at most this times the third power of the distance from the axis.
constexpr double kNoDistortion = 1e-12;

const char* const kCalibrate =
    "calibrate both cameras together (rosrun camera_calibration cameracalibrator.py with left and right "
    "camera) and record camera_info again, or put a corrsel/GroundTruth topic into the bag";

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw std::invalid_argument("camera_info on " + name + " " + what);
}

template <class Array>
bool allZero(const Array& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return number == 0.0; });
}

template <class Array>
bool allFinite(const Array& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

bool isRotation(const cv::Matx33d& matrix) {
  const cv::Matx33d difference = matrix * matrix.t() - cv::Matx33d::eye();
  return cv::norm(difference, cv::NORM_INF) <= kRotationTolerance && cv::determinant(matrix) > 0;
}

void requireIntrinsics(const std::string& name, const char* field, double fx, double fy, double w) {
  if (fx > 0 && fy > 0 && w != 0) return;
  refuse(name, std::string("has a matrix ") + field + " without positive focal lengths (" +
                   core::formatNumber(fx) + ", " + core::formatNumber(fy) + "); " + kCalibrate);
}

void validate(const RigCamera& camera) {
  const sensor_msgs::CameraInfo& info = camera.info;
  const std::string& name = camera.name;
  if (!allFinite(info.K) || !allFinite(info.P) || !allFinite(info.R) || !allFinite(info.D)) {
    refuse(name, std::string("holds numbers that are not finite; ") + kCalibrate);
  }
  if (allZero(info.K) && allZero(info.P)) {
    refuse(name, std::string("is all zero: the camera is not calibrated; ") + kCalibrate);
  }
  if (allZero(info.P)) {
    refuse(name,
           std::string("has K but no P: how the camera stands to the other one is unknown; ") + kCalibrate);
  }
  requireIntrinsics(name, "P", info.P[0], info.P[5], info.P[10]);
  if (info.width == 0 || info.height == 0) {
    refuse(name, "gives the image size " + std::to_string(info.width) + "x" + std::to_string(info.height) +
                     "; set width and height to the size the camera was calibrated at");
  }
  if (camera.rectified) return;
  if (allZero(info.K)) {
    refuse(name, std::string("has P but no K, so that raw images cannot be rectified; say images = rectified "
                             "if they already are, else ") +
                     kCalibrate);
  }
  requireIntrinsics(name, "K", info.K[0], info.K[4], info.K[8]);
  if (!isRotation(cv::Matx33d(info.R.data()))) {
    refuse(name, std::string("has a matrix R that is not a rotation; ") + kCalibrate);
  }
}

/// image_geometry takes D = 0 for "nothing to do" and then leaves out R, P and the equidistant projection
/// too; a coefficient that moves no pixel makes it apply them. A camera without distortion needs no model.
sensor_msgs::CameraInfo withMaps(sensor_msgs::CameraInfo info) {
  namespace models = sensor_msgs::distortion_models;
  if (!allZero(info.D)) return info;
  if (info.distortion_model.empty()) info.distortion_model = models::PLUMB_BOB;
  info.D.assign(info.distortion_model == models::EQUIDISTANT ? 4 : 5, 0.0);
  info.D[0] = kNoDistortion;
  return info;
}

cv::Matx33d crossMatrix(const cv::Vec3d& v) { return {0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0}; }

cv::Matx33d inverseCamera(const cv::Matx34d& p) { return p.get_minor<3, 3>(0, 0).inv(); }

/// The camera's translation in the rectified frame, m.
cv::Vec3d translation(const cv::Matx34d& p) {
  return inverseCamera(p) * cv::Vec3d(p(0, 3), p(1, 3), p(2, 3));
}

}  // namespace

StereoRig::Camera::Camera(const RigCamera& camera) : rectified_(camera.rectified), name_(camera.name) {
  validate(camera);
  model_.fromCameraInfo(withMaps(camera.info));
  const cv::Rect roi = model_.rawRoi();
  const cv::Rect full(cv::Point(), model_.fullResolution());
  size_ = cv::Size(roi.width / static_cast<int>(model_.binningX()),
                   roi.height / static_cast<int>(model_.binningY()));
  if ((roi & full) != roi || size_.empty()) {
    refuse(name_, "has a region of interest or a binning that does not fit into its " +
                      std::to_string(full.width) + "x" + std::to_string(full.height) + " px");
  }
  if (rectified_) return;
  try {  // makes the maps, and so finds out what image_geometry cannot do
    cv::Mat rectified;
    model_.rectifyImage(cv::Mat::zeros(size_, CV_8UC1), rectified);
  } catch (const image_geometry::Exception&) {
    refuse(name_, "has the distortion model '" + camera.info.distortion_model +
                      "', which image_geometry does not know (it knows plumb_bob, rational_polynomial and "
                      "equidistant); record rectified images and say images = rectified");
  } catch (const cv::Exception& error) {
    refuse(name_, "cannot be used: " + std::to_string(camera.info.D.size()) +
                      " distortion coefficients of the model '" + camera.info.distortion_model + "' (" +
                      error.err + "); " + kCalibrate);
  }
}

cv::Mat StereoRig::Camera::rectify(const cv::Mat& image) const {
  if (image.size() != size_) {
    throw std::invalid_argument(
        "the image has " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
        " px, camera_info on " + name_ + " is for " + std::to_string(size_.width) + "x" +
        std::to_string(size_.height) +
        " px (width and height, less region of interest and binning); record the camera_info that belongs to "
        "the images");
  }
  if (rectified_) return image;
  cv::Mat rectified;
  model_.rectifyImage(image, rectified);
  return rectified;
}

StereoRig::StereoRig(const RigCamera& left, const RigCamera& right) : left_(left), right_(right) {
  const cv::Vec3d shift = translation(right_.projection()) - translation(left_.projection());
  baseline_ = cv::norm(shift);
  if (!(baseline_ >= kLeastBaseline)) {
    throw std::invalid_argument(
        "camera_info on " + left.name + " and " + right.name +
        " have the same fourth column in P, a baseline of zero: the cameras were calibrated one by one, or "
        "both topics are of one camera; " +
        kCalibrate);
  }
  const cv::Matx33d f =
      inverseCamera(right_.projection()).t() * crossMatrix(shift) * inverseCamera(left_.projection());
  fundamental_ = f * (1.0 / cv::norm(f));
}

}  // namespace corrsel
