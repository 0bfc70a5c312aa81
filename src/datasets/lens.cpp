#include "datasets/lens.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "base/text.h"
#include "datasets/files.h"

namespace corrsel::core {
namespace {

constexpr double kMaxSide = 1 << 20;    // px; OpenCV reads images up to this
constexpr double kEnlargement = 1.005;  // in one step
constexpr int kSteps = 100;             // up to a factor of 1.65
constexpr double kMaxBeyond = 0.5;      // px: the outer half of the outermost pixels is still content

std::string sizeText(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height) + " px";
}

}  // namespace

Lens::Lens(const std::string& name, const cv::Matx33d& camera, const std::vector<double>& distortion,
           const cv::Size& size)
    : name_(name), original_(camera), camera_(camera), distortion_(distortion), size_(size) {
  const bool finite = cv::checkRange(camera) && std::all_of(distortion.begin(), distortion.end(),
                                                            [](double k) { return std::isfinite(k); });
  if (!finite) throw std::invalid_argument(name + " has a number that is not finite");
  const double fx = camera(0, 0), fy = camera(1, 1), cx = camera(0, 2), cy = camera(1, 2);
  if (!(fx > 0 && fy > 0)) {
    throw std::invalid_argument(name + " has the focal lengths " + formatNumber(fx) + " and " +
                                formatNumber(fy) + " px; they must be above 0");
  }
  if (!size.empty() && !(cx >= 0 && cy >= 0 && cx < size.width && cy < size.height)) {
    throw std::invalid_argument(name + " has its principal point at (" + formatNumber(cx) + ", " +
                                formatNumber(cy) + "), outside its images of " + sizeText(size));
  }
  if (std::all_of(distortion_.begin(), distortion_.end(), [](double k) { return k == 0; })) {
    distortion_.clear();
  }
  if (distortion_.empty()) return;
  camera_ = cv::Mat(cv::getOptimalNewCameraMatrix(original_, distortion_, size_, 0));
  // OpenCV looks at nine points of each side only.
  const cv::Point2d centre((size_.width - 1) / 2.0, (size_.height - 1) / 2.0);
  for (int step = 0; step < kSteps && !(beyondBorder() <= kMaxBeyond); ++step) {
    camera_(0, 0) *= kEnlargement;
    camera_(1, 1) *= kEnlargement;
    camera_(0, 2) = centre.x + (camera_(0, 2) - centre.x) * kEnlargement;
    camera_(1, 2) = centre.y + (camera_(1, 2) - centre.y) * kEnlargement;
  }
  if (!(beyondBorder() <= kMaxBeyond) || !(camera_(0, 0) > 0) || !(camera_(1, 1) > 0)) {
    throw std::invalid_argument(name + " has a distortion that cannot be removed from images of " +
                                sizeText(size) + "; check its coefficients and their order");
  }
}

/// How far the border of the undistorted image lies outside the original one, px.
double Lens::beyondBorder() const {
  std::vector<cv::Point3d> rays;
  const auto add = [&](int x, int y) {
    rays.emplace_back((x - camera_(0, 2)) / camera_(0, 0), (y - camera_(1, 2)) / camera_(1, 1), 1);
  };
  for (int x = 0; x < size_.width; ++x) {
    add(x, 0);
    add(x, size_.height - 1);
  }
  for (int y = 0; y < size_.height; ++y) {
    add(0, y);
    add(size_.width - 1, y);
  }
  std::vector<cv::Point2d> points;
  cv::projectPoints(rays, cv::Vec3d(), cv::Vec3d(), original_, distortion_, points);
  double beyond = 0;
  for (const cv::Point2d& point : points) {
    for (const double outside :
         {-point.x, -point.y, point.x - (size_.width - 1), point.y - (size_.height - 1)}) {
      if (!(outside <= beyond)) beyond = outside;  // NaN, too
    }
  }
  return beyond;
}

cv::Mat Lens::undistorted(const cv::Mat& image) const {
  if (!size_.empty() && image.size() != size_) {
    throw std::invalid_argument("the image has " + sizeText(image.size()) + ", " + name_ + " is for " +
                                sizeText(size_));
  }
  if (size_.empty() && !(camera_(0, 2) < image.cols && camera_(1, 2) < image.rows)) {
    throw std::invalid_argument("the image has " + sizeText(image.size()) + ", and the principal point of " +
                                name_ + " lies outside it, at (" + formatNumber(camera_(0, 2)) + ", " +
                                formatNumber(camera_(1, 2)) + "): the calibration is for another size");
  }
  if (!distorted()) return image;
  cv::Mat map_x, map_y, result;
  cv::initUndistortRectifyMap(original_, distortion_, cv::noArray(), camera_, size_, CV_32FC1, map_x, map_y);
  // The outer half of a border pixel is that pixel, and not a mixture with black.
  cv::remap(image, result, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

std::string Lens::text() const {
  return "images of " + name_ + " (" + sizeText(size_) + ") are undistorted; their new camera has fx " +
         roundedText(camera_(0, 0)) + ", fy " + roundedText(camera_(1, 1)) + ", cx " +
         roundedText(camera_(0, 2)) + ", cy " + roundedText(camera_(1, 2)) + " px";
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
