#include "ros/bags/stereo_rig.h"

#include <sensor_msgs/distortion_models.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/size_text.h"
#include "base/text.h"
#include "corrsel/ros/cameras.h"

namespace corrsel {
namespace {

constexpr double kMinBaseline = 1e-6;         // m
constexpr int kMinSide = 16;                  // px
constexpr double kDerivativeStep = 0.5;       // px
constexpr double kInversionTolerance = 0.05;  // px, of a point that is distorted again
constexpr int kInversionSteps = 100;
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

/// From pixels of an area to those of the whole image.
cv::Matx33d shiftBy(const cv::Point& by) {
  return {1, 0, static_cast<double>(by.x), 0, 1, static_cast<double>(by.y), 0, 0, 1};
}

/// The largest rectangle without a zero; of several, the first found. For every row, the columns' runs of
/// non-zeros that end there are the bars of a histogram, whose largest rectangle one pass with a stack finds.
cv::Rect largestRectangle(const cv::Mat& mask) {
  cv::Rect best;
  std::vector<int> heights(static_cast<std::size_t>(mask.cols) + 1, 0);  // the last one stays 0, closing all
  std::vector<int> starts;                                               // columns of rising bars
  for (int y = 0; y < mask.rows; ++y) {
    const std::uint8_t* const row = mask.ptr(y);
    starts.clear();
    for (int x = 0; x <= mask.cols; ++x) {
      int& height = heights[static_cast<std::size_t>(x)];
      if (x < mask.cols) height = row[x] != 0 ? height + 1 : 0;
      while (!starts.empty() && heights[static_cast<std::size_t>(starts.back())] >= height) {
        const int top = heights[static_cast<std::size_t>(starts.back())];
        starts.pop_back();
        const int left = starts.empty() ? 0 : starts.back() + 1;
        if (top * (x - left) > best.area()) best = {left, y - top + 1, x - left, top};
      }
      starts.push_back(x);
    }
  }
  return best;
}

}  // namespace

StereoRig::Camera::Camera(const RigCamera& camera) : rectified(camera.rectified), name(camera.name) {
  validate(camera);
  model.fromCameraInfo(withMaps(camera.info));
  const cv::Rect roi = model.rawRoi();
  const cv::Rect full(cv::Point(), model.fullResolution());
  size = cv::Size(roi.width / static_cast<int>(model.binningX()),
                  roi.height / static_cast<int>(model.binningY()));
  if ((roi & full) != roi || size.empty()) {
    refuse(name, "has a region of interest or a binning that does not fit into its " +
                     core::sizeText(full.size()) + " px");
  }
  area = cv::Rect(cv::Point(), size);
  if (rectified) return;
  try {  // makes the maps, and so finds out what image_geometry cannot do
    rectifyWhole(cv::Mat::zeros(size, CV_8UC1));
  } catch (const image_geometry::Exception&) {
    refuse(name,
           "has the distortion model '" + camera.info.distortion_model +
               "', which this version of image_geometry does not know (plumb_bob and rational_polynomial are "
               "known, and equidistant from version 1.16 on); record rectified images and set images = "
               "rectified");
  } catch (const cv::Exception& error) {
    refuse(name, "cannot be used: " + std::to_string(camera.info.D.size()) +
                     " distortion coefficients of the model '" + camera.info.distortion_model + "' (" +
                     error.err + "); " + kCalibrate);
  }
}

cv::Mat StereoRig::Camera::rectifyWhole(const cv::Mat& image) const {
  cv::Mat result;
  model.rectifyImage(image, result);
  return result;
}

cv::Mat StereoRig::Camera::rectify(const cv::Mat& image) const {
  if (image.size() != size) {
    throw std::invalid_argument(
        "the image has " + core::sizeText(image.size()) + " px, camera_info on " + name + " is for " +
        core::sizeText(size) +
        " px (width and height, less region of interest and binning); record the camera_info that belongs to "
        "the images");
  }
  return rectified ? image : rectifyWhole(image)(area).clone();
}

/// Points of the camera's images in the whole rectified image, px. OpenCV's own five steps leave up to some
/// pixels at the corners of a wide lens.
std::vector<cv::Point2d> StereoRig::Camera::undistorted(const std::vector<cv::Point2d>& points) const {
  std::vector<cv::Point2d> result;
  if (points.empty()) return result;
  const auto &k = model.intrinsicMatrix(), &r = model.rotationMatrix();
  if (model.cameraInfo().distortion_model == sensor_msgs::distortion_models::EQUIDISTANT) {
    cv::fisheye::undistortPoints(points, result, k, model.distortionCoeffs(), r, model.projectionMatrix());
  } else {
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kInversionSteps, 1e-6);
    cv::undistortPoints(points, result, k, model.distortionCoeffs(), r, model.projectionMatrix(), until);
  }
  return result;
}

/// Points of the whole rectified image in the camera's image, px; the inverse of undistorted(). It is
/// image_geometry's unrectifyPoint() in one call for all points.
std::vector<cv::Point2d> StereoRig::Camera::distorted(const std::vector<cv::Point2d>& points) const {
  std::vector<cv::Point2d> result;
  if (points.empty()) return result;
  // image_geometry takes P's fourth column off a pixel before it makes a ray of it.
  const cv::Point2d shift(model.Tx(), model.Ty());
  std::vector<cv::Point3d> rays;
  rays.reserve(points.size());
  for (const cv::Point2d& point : points) rays.push_back(model.projectPixelTo3dRay(point + shift));
  cv::Vec3d turn;
  cv::Rodrigues(model.rotationMatrix().t(), turn);
  if (model.cameraInfo().distortion_model == sensor_msgs::distortion_models::EQUIDISTANT) {
    cv::fisheye::projectPoints(rays, result, turn, cv::Vec3d(), model.intrinsicMatrix(),
                               model.distortionCoeffs());
  } else {
    cv::projectPoints(rays, turn, cv::Vec3d(), model.intrinsicMatrix(), model.distortionCoeffs(), result);
  }
  return result;
}

std::vector<cv::Point2f> StereoRig::Camera::recorded(const std::vector<cv::Point2f>& points) const {
  if (rectified) return points;
  std::vector<cv::Point2d> whole;
  whole.reserve(points.size());
  for (const cv::Point2f& point : points) whole.push_back(cv::Point2d(point) + cv::Point2d(area.tl()));
  const std::vector<cv::Point2d> seen = distorted(whole);
  return {seen.begin(), seen.end()};
}

/// Positions in the area that is kept, px. NaN beyond it, and where `whole` is not the inverse of the lens.
/// @param points  of the camera's images @param whole  undistorted(points)
std::vector<cv::Point2d> StereoRig::Camera::kept(const std::vector<cv::Point2d>& points,
                                                 const std::vector<cv::Point2d>& whole) const {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::vector<cv::Point2d> back = distorted(whole);
  std::vector<cv::Point2d> positions;
  positions.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Point2d position = whole[i] - cv::Point2d(area.tl());
    const bool inside =
        position.x >= 0 && position.y >= 0 && position.x <= area.width - 1 && position.y <= area.height - 1;
    const bool inverse = cv::norm(back[i] - points[i]) <= kInversionTolerance;
    positions.push_back(inside && inverse ? position : cv::Point2d(kNaN, kNaN));
  }
  return positions;
}

std::vector<cv::Point2f> StereoRig::Camera::positions(const std::vector<cv::Point2f>& points) const {
  if (rectified) return points;
  const std::vector<cv::Point2d> seen(points.begin(), points.end());
  const std::vector<cv::Point2d> result = kept(seen, undistorted(seen));
  return {result.begin(), result.end()};
}

std::vector<cv::Matx23d> StereoRig::Camera::rectify(const std::vector<cv::Point2f>& points) const {
  std::vector<cv::Matx23d> maps;
  maps.reserve(points.size());
  if (rectified) {
    for (const cv::Point2f& point : points) maps.emplace_back(1, 0, point.x, 0, 1, point.y);
    return maps;
  }
  constexpr double h = kDerivativeStep;
  const std::vector<cv::Point2d> seen(points.begin(), points.end());
  std::vector<cv::Point2d> beside;  // four of every point
  beside.reserve(4 * seen.size());
  for (const cv::Point2d& point : seen) {
    for (const cv::Point2d& step : {cv::Point2d(h, 0), {-h, 0}, {0, h}, {0, -h}}) {
      beside.push_back(point + step);
    }
  }
  const std::vector<cv::Point2d> position = kept(seen, undistorted(seen)), to = undistorted(beside);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (std::isnan(position[i].x)) {
      maps.push_back(cv::Matx23d::all(position[i].x));
      continue;
    }
    const cv::Point2d* const at = &to[4 * i];
    const cv::Point2d by_x = (at[0] - at[1]) / (2 * h), by_y = (at[2] - at[3]) / (2 * h);
    maps.emplace_back(by_x.x, by_y.x, position[i].x, by_x.y, by_y.y, position[i].y);
  }
  return maps;
}

/// 255 where a pixel of the rectified image is made of nothing but pixels of the camera, else 0.
cv::Mat StereoRig::Camera::seen() const {
  const cv::Mat white(size, CV_8UC1, cv::Scalar(255));
  return rectified ? white : cv::Mat(rectifyWhole(white) == 255);
}

/// The inverse of M, P = [M | p].
cv::Matx33d StereoRig::Camera::ray() const { return model.projectionMatrix().get_minor<3, 3>(0, 0).inv(); }

/// t, of P = M [I | t], m.
cv::Vec3d StereoRig::Camera::translation() const {
  const cv::Matx34d& p = model.projectionMatrix();
  return ray() * cv::Vec3d(p(0, 3), p(1, 3), p(2, 3));
}

void StereoRig::chooseAreas() {
  cv::Mat left_seen = left_.seen(), right_seen = right_.seen();
  if (left_.size == right_.size) left_seen = right_seen = left_seen & right_seen;
  for (const auto& [camera, seen] : {std::pair(&left_, left_seen), std::pair(&right_, right_seen)}) {
    if (camera->rectified) continue;
    camera->area = largestRectangle(seen);
    if (std::min(camera->area.width, camera->area.height) < kMinSide) {
      refuse(camera->name,
             "leaves next to nothing of the image when it is rectified: R and P do not fit to K; " +
                 std::string(kCalibrate));
    }
  }
}

StereoRig::StereoRig(const RigCamera& left, const RigCamera& right) : left_(left), right_(right) {
  pose_.translation = right_.translation() - left_.translation();
  if (!(baseline() >= kMinBaseline)) {
    throw std::invalid_argument(
        "camera_info on " + left.name + " and " + right.name +
        " have the same fourth column in P, a baseline of zero: the cameras were calibrated one by one, or "
        "both topics are of one camera; " +
        kCalibrate);
  }
  chooseAreas();
  pose_.left_camera = (left_.ray() * shiftBy(left_.area.tl())).inv();
  pose_.right_camera = (right_.ray() * shiftBy(right_.area.tl())).inv();
  fundamental_ = pose_.fundamental();
}

}  // namespace corrsel
