#include "datasets/generator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

#include "base/checksum.h"

namespace corrsel::core {
namespace {

constexpr double kNoiseSigma = 2.0;  // grey levels

constexpr int kSubPixels = 32;        // the grid on which warp() interpolates, per px
constexpr int kSignificantBits = 40;  // of the elements of a homography
constexpr int kWeightSum = 256;       // of the weights of blur()

cv::Matx33d translation(double x, double y) { return {1, 0, x, 0, 1, y, 0, 0, 1}; }

/// The weights of a Gaussian from its centre to one side. Rounding errors are passed on from the outside
/// inwards, so the weights of both sides and the centre add up to kWeightSum.
std::vector<int> gaussianWeights(double sigma) {
  const int radius = cvRound(6 * sigma + 1) / 2;
  std::vector<double> exact;
  double total = 0;
  for (int i = 0; i <= radius; ++i) {
    exact.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    total += (i > 0 ? 2 : 1) * exact.back();
  }
  std::vector<int> weights(exact.size());
  weights[0] = kWeightSum;
  double error = 0;
  for (auto i = exact.size() - 1; i > 0; --i) {
    const double wanted = kWeightSum * exact[i] / total + error;
    weights[i] = cvRound(wanted);
    error = wanted - weights[i];
    weights[0] -= 2 * weights[i];
  }
  return weights;
}

/// The place of a coordinate on the grid. Values beyond all images are cut off.
int onGrid(double coordinate) {
  constexpr double kFar = 1e6;
  return cvRound(kSubPixels * std::clamp(coordinate, -kFar, kFar));
}

/// Rounds down, for negative places too.
int pixelOf(int place) { return (place < 0 ? place - (kSubPixels - 1) : place) / kSubPixels; }

}  // namespace

Random engineOf(std::int64_t seed, const std::string& sequence, int strength) {
  Checksum checksum;
  checksum.add(std::to_string(seed) + "/" + sequence + "/" + std::to_string(strength));
  return Random(checksum.value());
}

cv::Matx33d rounded(const cv::Matx33d& homography) {
  cv::Matx33d result;
  for (int i = 0; i < 9; ++i) {
    int exponent = 0;
    const double fraction = std::frexp(homography.val[i], &exponent);
    result.val[i] =
        std::ldexp(std::nearbyint(std::ldexp(fraction, kSignificantBits)), exponent - kSignificantBits);
  }
  return result;
}

cv::Matx33d aboutCentre(const cv::Matx33d& map, const cv::Size& size) {
  const double x = 0.5 * (size.width - 1);
  const double y = 0.5 * (size.height - 1);
  const cv::Matx33d homography = translation(x, y) * map * translation(-x, -y);
  return rounded(homography * (1.0 / homography(2, 2)));
}

cv::Matx33d similarity(double scale, double degrees, const cv::Size& size) {
  const double c = std::cos(degrees * CV_PI / 180.0) / scale;
  const double s = std::sin(degrees * CV_PI / 180.0) / scale;
  return aboutCentre({c, -s, 0, s, c, 0, 0, 0, 1}, size);
}

cv::Mat blur(const cv::Mat& image, double sigma, cv::BorderTypes border) {
  const std::vector<int> weights = gaussianWeights(sigma);
  const int radius = static_cast<int>(weights.size()) - 1, channels = image.channels();
  const int values = image.cols * channels;
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, radius, radius, radius, radius, border);
  cv::Mat rows(padded.rows, values, CV_32S);
  for (int y = 0; y < padded.rows; ++y) {
    const std::uint8_t* const from = padded.ptr(y);
    int* const to = rows.ptr<int>(y);
    std::fill_n(to, values, 0);
    for (int k = -radius; k <= radius; ++k) {
      const int weight = weights[static_cast<std::size_t>(std::abs(k))];
      for (int i = 0; i < values; ++i) to[i] += weight * from[i + (k + radius) * channels];
    }
  }
  cv::Mat result(image.size(), image.type());
  std::vector<int> sums(static_cast<std::size_t>(values));
  for (int y = 0; y < image.rows; ++y) {
    constexpr int kSquaredSum = kWeightSum * kWeightSum;
    std::fill(sums.begin(), sums.end(), kSquaredSum / 2);
    for (int k = -radius; k <= radius; ++k) {
      const int weight = weights[static_cast<std::size_t>(std::abs(k))];
      const int* const from = rows.ptr<int>(y + k + radius);
      for (int i = 0; i < values; ++i) sums[static_cast<std::size_t>(i)] += weight * from[i];
    }
    std::uint8_t* const to = result.ptr(y);
    for (int i = 0; i < values; ++i) {
      to[i] = static_cast<std::uint8_t>(sums[static_cast<std::size_t>(i)] / kSquaredSum);
    }
  }
  return result;
}

cv::Mat antialiased(const cv::Mat& image, const cv::Matx33d& homography) {
  const cv::Vec3d centre(0.5 * (image.cols - 1), 0.5 * (image.rows - 1), 1.0);
  const double depth = homography.row(2).dot(centre.t());
  const double area_scale = std::abs(cv::determinant(homography) / (depth * depth * depth));
  if (area_scale >= 0.9) return image;
  return blur(image, 0.5 * std::sqrt(1.0 / area_scale - 1.0), cv::BORDER_REPLICATE);
}

cv::Mat warp(const cv::Mat& image, const cv::Matx33d& homography) {
  const cv::Matx33d back = homography.inv();
  const int channels = image.channels();
  const std::vector<std::uint8_t> black(image.elemSize());
  const auto pixel = [&](int x, int y) {
    const bool inside = x >= 0 && y >= 0 && x < image.cols && y < image.rows;
    return inside ? image.ptr(y, x) : black.data();
  };
  cv::Mat warped = cv::Mat::zeros(image.size(), image.type());
  for (int y = 0; y < warped.rows; ++y) {
    for (int x = 0; x < warped.cols; ++x) {
      const cv::Vec3d from = back * cv::Vec3d(x, y, 1);
      if (from[2] == 0) continue;
      const int place_x = onGrid(from[0] / from[2]), place_y = onGrid(from[1] / from[2]);
      const int left = pixelOf(place_x), top = pixelOf(place_y);
      const int to_left = place_x - kSubPixels * left, to_top = place_y - kSubPixels * top;
      const int to_right = kSubPixels - to_left, to_bottom = kSubPixels - to_top;
      const std::uint8_t* const left_top = pixel(left, top);
      const std::uint8_t* const right_top = pixel(left + 1, top);
      const std::uint8_t* const left_bottom = pixel(left, top + 1);
      const std::uint8_t* const right_bottom = pixel(left + 1, top + 1);
      std::uint8_t* const to = warped.ptr(y, x);
      for (int c = 0; c < channels; ++c) {
        const int upper = to_right * left_top[c] + to_left * right_top[c];
        const int lower = to_right * left_bottom[c] + to_left * right_bottom[c];
        constexpr int kArea = kSubPixels * kSubPixels;
        to[c] = static_cast<std::uint8_t>((to_bottom * upper + to_top * lower + kArea / 2) / kArea);
      }
    }
  }
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
