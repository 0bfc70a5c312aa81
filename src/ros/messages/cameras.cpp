#include "corrsel/ros/cameras.h"

#include <image_geometry/pinhole_camera_model.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <vector>

#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "ros/messages/image_side.h"

namespace corrsel {
namespace {

constexpr double kMinBaseline = 1e-6;        // m
constexpr double kRotationTolerance = 1e-3;  // largest entry of R R^T - I

const char* const kCalibrate = "calibrate the camera (rosrun camera_calibration cameracalibrator.py)";

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

template <class Array>
bool allZero(const Array& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return number == 0.0; });
}

template <class Array>
std::string listOf(const Array& numbers) {
  std::vector<std::string> texts;
  for (const double number : numbers) {  // formatNumber() writes NaN as nothing
    texts.push_back(std::isnan(number) ? "nan" : core::formatNumber(number));
  }
  return "[" + core::joinList(texts, ", ") + "]";
}

template <class Array>
void requireFinite(const std::string& field, const Array& numbers) {
  const bool finite =
      std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
  if (!finite) refuse(field + " is " + listOf(numbers) + ", expected finite numbers; " + kCalibrate);
}

/// A matrix of a camera_info, by the name of its field.
template <class Array>
void requireFocalLengths(const std::string& field, const Array& numbers, double fx, double fy, double w) {
  requireFinite(field, numbers);
  if (allZero(numbers)) refuse(field + " is all zero: the camera is not calibrated; " + kCalibrate);
  if (fx > 0 && fy > 0 && w != 0) return;
  refuse(field + " is " + listOf(numbers) + ", expected positive focal lengths; " + kCalibrate);
}

/// The size of the images, px: what the region of interest and the binning leave of the whole image.
cv::Size imageSize(const sensor_msgs::CameraInfo& info) {
  if (info.width == 0 || info.height == 0 || info.width > kMaxImageSide || info.height > kMaxImageSide) {
    refuse("width x height is " + std::to_string(info.width) + "x" + std::to_string(info.height) +
           "; set them to the size at which the camera was calibrated");
  }
  const std::uint32_t binning_x = std::max(info.binning_x, 1u), binning_y = std::max(info.binning_y, 1u);
  const bool whole = info.roi.width == 0 || info.roi.height == 0;  // as image_geometry understands it
  const std::uint64_t width = whole ? info.width : info.roi.width;
  const std::uint64_t height = whole ? info.height : info.roi.height;
  const std::uint64_t right = width + (whole ? 0 : info.roi.x_offset);
  const std::uint64_t bottom = height + (whole ? 0 : info.roi.y_offset);
  if (right > info.width || bottom > info.height || binning_x > width || binning_y > height) {
    refuse("the region of interest (roi, " + std::to_string(width) + "x" + std::to_string(height) + " at " +
           std::to_string(info.roi.x_offset) + ", " + std::to_string(info.roi.y_offset) +
           ") or the binning (" + std::to_string(binning_x) + "x" + std::to_string(binning_y) +
           ") does not fit into the " + std::to_string(info.width) + "x" + std::to_string(info.height) +
           " px of width and height; correct the camera's driver");
  }
  return {static_cast<int>(width / binning_x), static_cast<int>(height / binning_y)};
}

/// The fields of raw images. image_geometry looks for a distortion only where a coefficient is not 0, and
/// drivers name the model of images without one as they like; a fisheye lens without coefficients is one.
core::CameraInfoFields rawFields(const sensor_msgs::CameraInfo& info) {
  core::CameraInfoFields fields;
  const bool fisheye = info.distortion_model == "equidistant" || info.distortion_model == "fisheye";
  if (fisheye || !allZero(info.D)) {
    fields.distortion_model = info.distortion_model;
    fields.d = info.D;
  }
  return fields;
}

/// A camera in the frame that the cameras of a rig share: a point X of that frame is rotation^T (X + shift)
/// in the frame of the camera.
struct RigCamera {
  cv::Matx33d rotation = cv::Matx33d::eye();
  cv::Vec3d shift;  ///< m
};

std::optional<RigCamera> rigCamera(const sensor_msgs::CameraInfo& info, bool rectified) {
  const auto& p = info.P;
  const bool usable = std::all_of(p.begin(), p.end(), [](double number) { return std::isfinite(number); }) &&
                      p[0] > 0 && p[5] > 0 && p[10] != 0;
  if (!usable) return {};
  RigCamera camera;
  const cv::Matx33d m(p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]);
  camera.shift = m.inv() * cv::Vec3d(p[3], p[7], p[11]);
  if (rectified) return camera;
  camera.rotation = cv::Matx33d(info.R.data());
  if (!isRotation(camera.rotation)) return {};
  return camera;
}

}  // namespace

bool isRectified(const std::string& images, const std::string& topic) {
  return images == "auto" ? topic.find("image_rect") != std::string::npos : images == "rectified";
}

bool isRotation(const cv::Matx33d& matrix) {
  const cv::Matx33d difference = matrix * matrix.t() - cv::Matx33d::eye();
  return cv::norm(difference, cv::NORM_INF) <= kRotationTolerance && cv::determinant(matrix) > 0;
}

core::Camera cameraOf(const sensor_msgs::CameraInfo& info, bool rectified) {
  if (rectified) {
    requireFocalLengths("P", info.P, info.P[0], info.P[5], info.P[10]);
  } else {
    requireFocalLengths("K", info.K, info.K[0], info.K[4], info.K[8]);
    requireFinite("D", info.D);
  }
  core::CameraInfoFields fields = rectified ? core::CameraInfoFields() : rawFields(info);
  fields.size = imageSize(info);
  image_geometry::PinholeCameraModel model;  // of both matrices, one of which may be missing
  model.fromCameraInfo(info);
  fields.k = rectified ? cv::Matx33d(model.projectionMatrix().get_minor<3, 3>(0, 0))
                       : cv::Matx33d(model.intrinsicMatrix());
  try {
    return core::cameraFromInfo(fields);
  } catch (const std::invalid_argument& error) {
    refuse(std::string(error.what()) + "; " + kCalibrate);
  }
}

sensor_msgs::CameraInfo cameraInfo(const core::Camera& camera) {
  const core::CameraInfoFields fields = core::cameraToInfo(camera);
  sensor_msgs::CameraInfo info;
  info.width = static_cast<std::uint32_t>(fields.size.width);
  info.height = static_cast<std::uint32_t>(fields.size.height);
  info.distortion_model = fields.distortion_model;
  info.D = fields.d;
  std::copy_n(fields.k.val, 9, info.K.begin());
  for (int i = 0; i < 3; ++i) {
    info.R[static_cast<std::size_t>(4 * i)] = 1;
    std::copy_n(fields.k.val + 3 * i, 3, info.P.begin() + 4 * i);
  }
  return info;
}

std::optional<RigPose> rigOf(const sensor_msgs::CameraInfo& left, bool left_rectified,
                             const sensor_msgs::CameraInfo& right, bool right_rectified) {
  const auto from = rigCamera(left, left_rectified), to = rigCamera(right, right_rectified);
  if (!from || !to) return {};
  const cv::Matx33d back = to->rotation.t();
  RigPose rig{back * from->rotation, back * (to->shift - from->shift)};
  if (cv::norm(rig.translation) < kMinBaseline) return {};
  return rig;
}

Camera toMsg(const std::optional<core::Camera>& camera) {
  Camera msg;
  if (!camera) return msg;
  msg.model = static_cast<std::uint8_t>(Camera::MODEL_PINHOLE + static_cast<std::uint8_t>(camera->model));
  msg.width = static_cast<std::uint32_t>(camera->size.width);
  msg.height = static_cast<std::uint32_t>(camera->size.height);
  std::copy_n(camera->matrix.val, msg.matrix.size(), msg.matrix.begin());
  std::copy(camera->distortion.begin(), camera->distortion.end(), msg.distortion.begin());
  return msg;
}

std::optional<core::Camera> fromMsg(const Camera& msg) {
  if (msg.model == Camera::MODEL_UNKNOWN) return {};
  if (msg.model > Camera::MODEL_EQUIRECTANGULAR) {
    throw std::invalid_argument("model is " + std::to_string(msg.model) + ", which is unknown");
  }
  if (msg.width > kMaxImageSide || msg.height > kMaxImageSide) {
    throw std::invalid_argument("size is " + std::to_string(msg.width) + "x" + std::to_string(msg.height) +
                                " px");
  }
  core::Camera camera;
  camera.model = static_cast<core::Camera::Model>(msg.model - Camera::MODEL_PINHOLE);
  camera.size = {static_cast<int>(msg.width), static_cast<int>(msg.height)};
  camera.matrix = cv::Matx33d(msg.matrix.data());
  std::copy(msg.distortion.begin(), msg.distortion.end(), camera.distortion.begin());
  camera.check();
  return camera;
}

}  // namespace corrsel
