#include "corrsel/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>  // cvRound(), comparison of matrices
#include <stdexcept>

#include "base/size_text.h"
#include "base/text.h"
#include "geometry/checked_matrix.h"
#include "geometry/lens.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

using Model = Camera::Model;

constexpr std::array<Model, 3> kModels = {Model::kPinhole, Model::kFisheye, Model::kEquirectangular};

std::size_t coefficients(Model model) {
  return model == Model::kPinhole ? 8 : model == Model::kFisheye ? 4 : 0;
}

void requireDistortion(const Camera& camera) {
  const std::size_t used = coefficients(camera.model);
  for (std::size_t i = 0; i < camera.distortion.size(); ++i) {
    const double value = camera.distortion[i];
    if (std::isfinite(value) && (i < used || value == 0)) continue;
    throw std::invalid_argument("distortion[" + std::to_string(i) +
                                "] = " + (std::isnan(value) ? "nan" : formatNumber(value)) +
                                (i < used ? " is not finite"
                                          : " must be 0: a " + toString(camera.model) + " camera has " +
                                                std::to_string(used) + " coefficients"));
  }
}

void requireSize(const Camera& camera) {
  const cv::Size& size = camera.size;
  const bool known = size.width > 0 && size.height > 0;
  const bool unknown = size.width == 0 && size.height == 0 && camera.model != Model::kEquirectangular;
  if (known || unknown) return;
  throw std::invalid_argument("size = " + sizeText(size) +
                              (camera.model == Model::kEquirectangular
                                   ? " must be positive: a panorama fills its image"
                                   : " must be positive, or 0x0 if it is unknown"));
}

bool toPixel(const cv::Matx33d& k, double x, double y, cv::Point2d& pixel) {
  pixel = {k(0, 0) * x + k(0, 1) * y + k(0, 2), k(1, 1) * y + k(1, 2)};
  return std::isfinite(pixel.x) && std::isfinite(pixel.y);
}

template <bool Rational>
bool projectPinhole(const LensModel& lens, const cv::Matx33d& matrix, double x, double y,
                    cv::Point2d& pixel) {
  const DistortedPoint<double> p = distortPinhole<Rational>(lens.distortion, x, y);
  if (!(p.determinant() > kSmallestSlope) || !(p.trace() > 0)) return false;
  return x * x + y * y < lens.limit && toPixel(matrix, p.x, p.y, pixel);
}

bool projectFisheye(const LensModel& lens, const cv::Matx33d& matrix, const cv::Vec3d& point,
                    cv::Point2d& pixel) {
  const double distance = std::hypot(point[0], point[1]);
  const double angle = std::atan2(distance, point[2]);
  const FisheyeRadius<double> radius = fisheyeRadius(lens.distortion, angle);
  if (!(angle < lens.limit) || !(radius.slope > kSmallestSlope)) return false;
  const double scale = distance > 0 ? radius.value / distance : 0;
  return toPixel(matrix, point[0] * scale, point[1] * scale, pixel);
}

bool projectEquirectangular(const cv::Size& size, const cv::Vec3d& point, cv::Point2d& pixel) {
  const double longitude = std::atan2(point[0], point[2]);
  const double latitude = std::atan2(point[1], std::hypot(point[0], point[2]));
  pixel = {(longitude / (2 * CV_PI) + 0.5) * size.width - 0.5, (latitude / CV_PI + 0.5) * size.height - 0.5};
  return size.width > 0 && size.height > 0;
}

}  // namespace

void Camera::check() const {
  if (std::find(kModels.begin(), kModels.end(), model) == kModels.end()) {
    throw std::invalid_argument("model = " + std::to_string(static_cast<int>(model)) +
                                " does not exist; valid: 0 to 2");
  }
  if (model != Model::kEquirectangular) requireCameraMatrix("matrix", matrix);
  requireDistortion(*this);
  requireSize(*this);
}

bool Camera::isPlainPinhole() const {
  return model == Model::kPinhole &&
         std::all_of(distortion.begin(), distortion.end(), [](double value) { return value == 0; });
}

Camera Camera::scaled(double factor) const {
  if (!(factor > 0) || !std::isfinite(factor)) {
    throw std::invalid_argument("factor = " + formatNumber(factor) + " must be positive and finite");
  }
  Camera result = *this;
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) result.matrix(row, column) *= factor;
    result.matrix(row, 2) = factor * (matrix(row, 2) + 0.5) - 0.5;
  }
  result.size = cv::Size(cvRound(size.width * factor), cvRound(size.height * factor));
  return result;
}

bool operator==(const Camera& a, const Camera& b) {
  return a.model == b.model && a.matrix == b.matrix && a.distortion == b.distortion && a.size == b.size;
}

std::string toString(Camera::Model model) {
  switch (model) {
    case Model::kFisheye:
      return "fisheye";
    case Model::kEquirectangular:
      return "equirectangular";
    case Model::kPinhole:
      break;
  }
  return "pinhole";
}

Camera::Model cameraModelFromString(const std::string& text) {
  std::vector<std::string> valid;
  for (const Model model : kModels) {
    if (toString(model) == text) return model;
    valid.push_back(toString(model));
  }
  throw std::invalid_argument("unknown camera model '" + text + "'" + validNames(text, valid));
}

bool unproject(const Camera& camera, const cv::Point2d& pixel, Ray& ray) {
  const PreparedLens lens = prepareLens(camera);
  std::array<double, 9> value;
  std::array<double*, 9> columns;
  for (std::size_t i = 0; i < value.size(); ++i) columns[i] = &value[i];
  const auto kernel = kernels().rays.unproject[static_cast<std::size_t>(lens.kind)];
  const bool exists = kernel(lens.model, &pixel.x, &pixel.y, 1, columns.data()) == 0;
  ray.direction = cv::Vec3d(value.data());
  ray.jacobian = cv::Matx<double, 3, 2>(value.data() + 3);
  return exists;
}

bool project(const Camera& camera, const cv::Vec3d& point, cv::Point2d& pixel) {
  const bool finite = std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
  if (!finite || point == cv::Vec3d()) return false;
  if (camera.model == Model::kEquirectangular) return projectEquirectangular(camera.size, point, pixel);
  const PreparedLens lens = prepareLens(camera);
  if (lens.kind == LensKind::kFisheye) return projectFisheye(lens.model, camera.matrix, point, pixel);
  if (!(point[2] > 0)) return false;
  const double x = point[0] / point[2], y = point[1] / point[2];
  return lens.kind == LensKind::kRationalPinhole
             ? projectPinhole<true>(lens.model, camera.matrix, x, y, pixel)
             : projectPinhole<false>(lens.model, camera.matrix, x, y, pixel);
}

}  // namespace corrsel::core
