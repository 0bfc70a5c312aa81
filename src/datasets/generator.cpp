#include "datasets/generator.h"

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/checksum.h"

namespace corrsel::core {
namespace {

constexpr double kNoiseSigma = 2.0;  // grey levels

cv::Matx33d translation(double x, double y) { return {1, 0, x, 0, 1, y, 0, 0, 1}; }

}  // namespace

Random engineOf(std::int64_t seed, const std::string& sequence, int strength) {
  Checksum checksum;
  checksum.add(std::to_string(seed) + "/" + sequence + "/" + std::to_string(strength));
  return Random(checksum.value());
}

cv::Matx33d aboutCentre(const cv::Matx33d& map, const cv::Size& size) {
  const double x = 0.5 * (size.width - 1);
  const double y = 0.5 * (size.height - 1);
  const cv::Matx33d homography = translation(x, y) * map * translation(-x, -y);
  return homography * (1.0 / homography(2, 2));
}

cv::Matx33d similarity(double scale, double degrees, const cv::Size& size) {
  const double c = std::cos(degrees * CV_PI / 180.0) / scale;
  const double s = std::sin(degrees * CV_PI / 180.0) / scale;
  return aboutCentre({c, -s, 0, s, c, 0, 0, 0, 1}, size);
}

cv::Mat warp(const cv::Mat& image, const cv::Matx33d& homography) {
  const cv::Vec3d centre(0.5 * (image.cols - 1), 0.5 * (image.rows - 1), 1.0);
  const double depth = homography.row(2).dot(centre.t());
  const double area_scale = std::abs(cv::determinant(homography) / (depth * depth * depth));
  cv::Mat smooth = image;
  if (area_scale < 0.9) {
    const double sigma = 0.5 * std::sqrt(1.0 / area_scale - 1.0);
    cv::GaussianBlur(image, smooth, cv::Size(), sigma, sigma, cv::BORDER_REPLICATE);
  }
  cv::Mat warped;
  cv::warpPerspective(smooth, warped, homography, image.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return warped;
}

void addNoise(cv::Mat& image, Random& random) {
  const int values = image.cols * image.channels();
  for (int y = 0; y < image.rows; ++y) {
    std::uint8_t* const row = image.ptr<std::uint8_t>(y);
    for (int i = 0; i < values; ++i) {
      row[i] = cv::saturate_cast<std::uint8_t>(row[i] + kNoiseSigma * random.normal());
    }
  }
}

}  // namespace corrsel::core
