#include "corrsel/camera_formats.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>

#include "base/text.h"

namespace corrsel::core {
namespace {

using Model = Camera::Model;

constexpr double kColmapCentre = 0.5;  // coordinates of the centre of COLMAP's first pixel

[[noreturn]] void refuse(const std::string& text) { throw std::invalid_argument(text); }

bool allZero(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return value == 0; });
}

void requireCount(const std::string& what, const std::vector<double>& values,
                  const std::vector<std::size_t>& valid) {
  if (std::find(valid.begin(), valid.end(), values.size()) != valid.end()) return;
  std::vector<std::string> texts;
  for (const std::size_t count : valid) texts.push_back(std::to_string(count));
  refuse(what + " has " + std::to_string(values.size()) + " numbers; valid: " + joinList(texts));
}

Camera checked(Model model, const cv::Matx33d& matrix, const std::vector<double>& distortion,
               const cv::Size& size) {
  Camera camera;
  camera.model = model;
  camera.matrix = matrix;
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  camera.size = size;
  camera.check();
  return camera;
}

cv::Matx33d cameraMatrix(double fx, double fy, double cx, double cy) {
  return {fx, 0, cx, 0, fy, cy, 0, 0, 1};
}

bool isRational(const Camera& camera) {
  const std::array<double, 8>& d = camera.distortion;
  return camera.model == Model::kPinhole && (d[5] != 0 || d[6] != 0 || d[7] != 0);
}

/// Checks a camera before it is converted. @param software  for the error text
void requireLens(const Camera& camera, const std::string& software) {
  camera.check();
  if (camera.model == Model::kEquirectangular) {
    refuse("model = equirectangular: " + software + " has no panoramas; valid: pinhole, fisheye");
  }
}

void requireNoSkew(const Camera& camera, const std::string& software) {
  if (camera.matrix(0, 1) != 0) {
    refuse("matrix has the skew " + formatNumber(camera.matrix(0, 1)) + "; " + software +
           " has none; valid: 0");
  }
}

/// One of COLMAP's models: parameters are [f | fx fy] cx cy, followed by the given coefficients.
struct ColmapModel {
  const char* name;
  Model model;
  std::size_t focal_lengths;
  std::size_t coefficients;
};

constexpr std::array<ColmapModel, 9> kColmapModels = {{
    {"SIMPLE_PINHOLE", Model::kPinhole, 1, 0},
    {"PINHOLE", Model::kPinhole, 2, 0},
    {"SIMPLE_RADIAL", Model::kPinhole, 1, 1},
    {"RADIAL", Model::kPinhole, 1, 2},
    {"OPENCV", Model::kPinhole, 2, 4},
    {"FULL_OPENCV", Model::kPinhole, 2, 8},
    {"OPENCV_FISHEYE", Model::kFisheye, 2, 4},
    {"SIMPLE_RADIAL_FISHEYE", Model::kFisheye, 1, 1},
    {"RADIAL_FISHEYE", Model::kFisheye, 1, 2},
}};

const ColmapModel& colmapModel(const std::string& name) {
  std::vector<std::string> valid;
  for (const ColmapModel& model : kColmapModels) {
    if (model.name == name) return model;
    valid.push_back(model.name);
  }
  refuse("COLMAP's camera model '" + name + "' is not supported" + validNames(name, valid));
}

}  // namespace

Camera cameraFromOpenCv(const cv::Matx33d& matrix, const std::vector<double>& distortion,
                        const cv::Size& size) {
  constexpr std::size_t kSupported = 8;
  requireCount("distortion", distortion, {0, 4, 5, 8, 12, 14});
  std::vector<double> coefficients = distortion;
  for (std::size_t i = kSupported; i < coefficients.size(); ++i) {
    if (coefficients[i] == 0) continue;
    refuse("distortion[" + std::to_string(i) + "] = " + formatNumber(coefficients[i]) +
           ": thin prism and tilt (s1 s2 s3 s4 tx ty) are not supported; valid: 0");
  }
  coefficients.resize(std::min(coefficients.size(), kSupported));
  return checked(Model::kPinhole, matrix, coefficients, size);
}

Camera cameraFromOpenCvFisheye(const cv::Matx33d& matrix, const std::vector<double>& distortion,
                               const cv::Size& size) {
  requireCount("distortion", distortion, {0, 4});
  return checked(Model::kFisheye, matrix, distortion, size);
}

std::vector<double> openCvDistortion(const Camera& camera) {
  requireLens(camera, "OpenCV");
  const std::size_t count = camera.model == Model::kFisheye ? 4 : isRational(camera) ? 8 : 5;
  return {camera.distortion.begin(), camera.distortion.begin() + static_cast<std::ptrdiff_t>(count)};
}

Camera cameraFromInfo(const CameraInfoFields& info) {
  const std::string& name = info.distortion_model;
  if (name == "equidistant" || name == "fisheye") return cameraFromOpenCvFisheye(info.k, info.d, info.size);
  if (name == "plumb_bob") {
    requireCount("distortion of plumb_bob", info.d, {0, 4, 5});
  } else if (name.empty()) {
    if (!allZero(info.d)) refuse("distortion_model is empty, but there are coefficients that are not 0");
    return cameraFromOpenCv(info.k, {}, info.size);
  } else if (name != "rational_polynomial") {
    refuse("distortion_model '" + name + "' is not supported" +
           validNames(name, {"plumb_bob", "rational_polynomial", "equidistant", "fisheye"}));
  }
  return cameraFromOpenCv(info.k, info.d, info.size);
}

CameraInfoFields cameraToInfo(const Camera& camera) {
  requireLens(camera, "CameraInfo");
  const bool fisheye = camera.model == Model::kFisheye;
  return {camera.size,
          fisheye              ? "equidistant"
          : isRational(camera) ? "rational_polynomial"
                               : "plumb_bob",
          openCvDistortion(camera), camera.matrix};
}

Camera cameraFromColmap(const ColmapCamera& colmap) {
  const ColmapModel& model = colmapModel(colmap.model);
  const std::vector<double>& p = colmap.parameters;
  const std::size_t centre = model.focal_lengths, first = centre + 2;
  requireCount("parameters of " + colmap.model, p, {first + model.coefficients});
  return checked(model.model,
                 cameraMatrix(p[0], p[centre - 1], p[centre] - kColmapCentre, p[centre + 1] - kColmapCentre),
                 {p.begin() + static_cast<std::ptrdiff_t>(first), p.end()}, colmap.size);
}

ColmapCamera cameraToColmap(const Camera& camera) {
  requireLens(camera, "COLMAP");
  requireNoSkew(camera, "COLMAP");
  const bool full = isRational(camera) || camera.distortion[4] != 0;
  // A name of its own: GCC 13 and later take the reference for one to the temporary text.
  const std::string name = camera.model == Model::kFisheye ? "OPENCV_FISHEYE"
                           : camera.isPlainPinhole()       ? "PINHOLE"
                           : full                          ? "FULL_OPENCV"
                                                           : "OPENCV";
  const ColmapModel& model = colmapModel(name);
  const cv::Matx33d& k = camera.matrix;
  ColmapCamera colmap{
      model.name, camera.size, {k(0, 0), k(1, 1), k(0, 2) + kColmapCentre, k(1, 2) + kColmapCentre}};
  colmap.parameters.insert(colmap.parameters.end(), camera.distortion.begin(),
                           camera.distortion.begin() + static_cast<std::ptrdiff_t>(model.coefficients));
  return colmap;
}

Camera cameraFromKalibr(const KalibrCamera& kalibr) {
  if (kalibr.camera_model != "pinhole") {
    refuse("camera_model '" + kalibr.camera_model + "' is not supported; valid: pinhole");
  }
  requireCount("intrinsics", kalibr.intrinsics, {4});
  const std::vector<double>& p = kalibr.intrinsics;
  const cv::Matx33d matrix = cameraMatrix(p[0], p[1], p[2], p[3]);
  const std::string& name = kalibr.distortion_model;
  if (name == "none") {
    if (!allZero(kalibr.distortion_coeffs)) {
      refuse("distortion_model is none, but there are coefficients that are not 0");
    }
    return checked(Model::kPinhole, matrix, {}, kalibr.resolution);
  }
  const bool radtan = name == "radtan" || name == "radial-tangential";
  if (!radtan && name != "equidistant" && name != "equi") {
    refuse("distortion_model '" + name + "' is not supported" +
           validNames(name, {"radtan", "radial-tangential", "equidistant", "equi", "none"}));
  }
  requireCount("distortion_coeffs of " + name, kalibr.distortion_coeffs, {4});
  return checked(radtan ? Model::kPinhole : Model::kFisheye, matrix, kalibr.distortion_coeffs,
                 kalibr.resolution);
}

KalibrCamera cameraToKalibr(const Camera& camera) {
  constexpr std::size_t kCoefficients = 4;
  requireLens(camera, "Kalibr");
  requireNoSkew(camera, "Kalibr");
  for (std::size_t i = kCoefficients; i < camera.distortion.size(); ++i) {
    if (camera.distortion[i] == 0) continue;
    refuse("distortion[" + std::to_string(i) + "] = " + formatNumber(camera.distortion[i]) +
           ": Kalibr's radtan has k1 k2 p1 p2 only; valid: 0");
  }
  const cv::Matx33d& k = camera.matrix;
  KalibrCamera kalibr{"pinhole", {k(0, 0), k(1, 1), k(0, 2), k(1, 2)}, "none", {}, camera.size};
  if (camera.isPlainPinhole()) return kalibr;
  kalibr.distortion_model = camera.model == Model::kFisheye ? "equidistant" : "radtan";
  kalibr.distortion_coeffs.assign(camera.distortion.begin(), camera.distortion.begin() + kCoefficients);
  return kalibr;
}

}  // namespace corrsel::core
