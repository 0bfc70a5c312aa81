#include "datasets/lens.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "base/size_text.h"
#include "base/text.h"
#include "datasets/files.h"

namespace corrsel::core {
namespace {

constexpr double kMaxSide = 1 << 20;    // px; OpenCV reads images up to this
constexpr double kEnlargement = 1.005;  // in one step
constexpr int kSteps = 100;             // up to a factor of 1.65
constexpr double kMaxBeyond = 0.5;      // px: the outer half of the outermost pixels is still content

}  // namespace

Lens::Lens(const std::string& name, const Camera& camera) : name_(name), original_(camera), camera_(camera) {
  try {
    camera.check();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(name + ": " + error.what());
  }
  if (camera.model == Camera::Model::kEquirectangular) return;
  const cv::Size size = camera.size;
  const double cx = camera.matrix(0, 2), cy = camera.matrix(1, 2);
  if (!size.empty() && !(cx >= 0 && cy >= 0 && cx < size.width && cy < size.height)) {
    throw std::invalid_argument(name + " has its principal point at (" + formatNumber(cx) + ", " +
                                formatNumber(cy) + "), outside its images of " + sizeText(size) + " px");
  }
  if (camera.model != Camera::Model::kPinhole || camera.isPlainPinhole()) return;
  camera_.distortion = {};
  cv::Matx33d& k = camera_.matrix;
  k = cv::Mat(cv::getOptimalNewCameraMatrix(original_.matrix, original_.distortion, size, 0));
  // OpenCV looks at nine points of each side only.
  const cv::Point2d centre((size.width - 1) / 2.0, (size.height - 1) / 2.0);
  for (int step = 0; step < kSteps && !(beyondBorder() <= kMaxBeyond); ++step) {
    k(0, 0) *= kEnlargement;
    k(1, 1) *= kEnlargement;
    k(0, 2) = centre.x + (k(0, 2) - centre.x) * kEnlargement;
    k(1, 2) = centre.y + (k(1, 2) - centre.y) * kEnlargement;
  }
  if (!(beyondBorder() <= kMaxBeyond) || !(k(0, 0) > 0) || !(k(1, 1) > 0)) {
    throw std::invalid_argument(name + " has a distortion that cannot be removed from images of " +
                                sizeText(size) + " px; check its coefficients and their order");
  }
}

/// How far the border of the undistorted image lies outside the original one, px.
double Lens::beyondBorder() const {
  const cv::Size size = original_.size;
  const cv::Matx33d& k = camera_.matrix;
  std::vector<cv::Point3d> rays;
  const auto add = [&](int x, int y) {
    rays.emplace_back((x - k(0, 2)) / k(0, 0), (y - k(1, 2)) / k(1, 1), 1);
  };
  for (int x = 0; x < size.width; ++x) {
    add(x, 0);
    add(x, size.height - 1);
  }
  for (int y = 0; y < size.height; ++y) {
    add(0, y);
    add(size.width - 1, y);
  }
  std::vector<cv::Point2d> points;
  cv::projectPoints(rays, cv::Vec3d(), cv::Vec3d(), original_.matrix, original_.distortion, points);
  double beyond = 0;
  for (const cv::Point2d& point : points) {
    for (const double outside :
         {-point.x, -point.y, point.x - (size.width - 1), point.y - (size.height - 1)}) {
      if (!(outside <= beyond)) beyond = outside;  // NaN, too
    }
  }
  return beyond;
}

cv::Mat Lens::undistorted(const cv::Mat& image) const {
  const cv::Size size = original_.size;
  if (!size.empty() && image.size() != size) {
    throw std::invalid_argument("the image has " + sizeText(image.size()) + " px, " + name_ + " is for " +
                                sizeText(size) + " px");
  }
  const cv::Matx33d& k = camera_.matrix;
  if (size.empty() && !(k(0, 2) < image.cols && k(1, 2) < image.rows)) {
    throw std::invalid_argument("the image has " + sizeText(image.size()) +
                                " px, and the principal point of " + name_ + " lies outside it, at (" +
                                formatNumber(k(0, 2)) + ", " + formatNumber(k(1, 2)) +
                                "): the calibration is for another size");
  }
  if (!distorted()) return image;
  cv::Mat map_x, map_y, result;
  cv::initUndistortRectifyMap(original_.matrix, original_.distortion, cv::noArray(), k, size, CV_32FC1, map_x,
                              map_y);
  // The outer half of a border pixel is that pixel, and not a mixture with black.
  cv::remap(image, result, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

std::string Lens::text() const {
  const cv::Matx33d& k = camera_.matrix;
  return "images of " + name_ + " (" + sizeText(original_.size) +
         " px) are undistorted; their new camera has fx " + roundedText(k(0, 0)) + ", fy " +
         roundedText(k(1, 1)) + ", cx " + roundedText(k(0, 2)) + ", cy " + roundedText(k(1, 2)) + " px";
}

cv::Size imageSize(double width, double height) {
  for (const double side : {width, height}) {
    if (side >= 1 && side <= kMaxSide && side == std::floor(side)) continue;
    throw std::invalid_argument("the size of the images, " + formatNumber(width) + "x" +
                                formatNumber(height) + ", is not one of 1 to " + formatNumber(kMaxSide) +
                                " px");
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace corrsel::core
