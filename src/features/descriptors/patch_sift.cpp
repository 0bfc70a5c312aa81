#include "features/descriptors/patch_sift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "features/parts/affine_patch.h"
#include "features/parts/feature_list.h"
#include "features/parts/root_sift.h"
#include "features/parts/sift_descriptor.h"

namespace corrsel::core {
namespace {

/// Blurred copies of an image. The resolution is halved whenever the blur allows it.
struct Pyramid {
  std::vector<cv::Mat> images;
  std::vector<ScaleLevel> levels;

  void add(const cv::Mat& image, double step, double sigma) {
    cv::Mat numbers;
    image.convertTo(numbers, CV_16S, kGreyUnit);
    images.push_back(numbers);
    levels.push_back({numbers.ptr<std::int16_t>(), static_cast<std::ptrdiff_t>(numbers.step1()), image.cols,
                      image.rows, step, sigma});
  }
};

/// Levels whose blurs are a factor of sqrt(2) apart, from `smallest` to `largest`, px.
Pyramid pyramidOf(const cv::Mat& grey, double smallest, double largest) {
  Pyramid pyramid;
  cv::Mat image;
  grey.convertTo(image, CV_32F);
  pyramid.add(image, 1, kCameraBlur);
  double step = 1, sigma = kCameraBlur;
  for (int k = 0; std::exp2(0.5 * k) <= largest; ++k) {
    const double next = std::exp2(0.5 * k);
    // After a blur of two pixels, every second pixel suffices.
    if (sigma / step >= 1.99 && std::min(image.cols, image.rows) >= 4) {
      cv::Mat half((image.rows + 1) / 2, (image.cols + 1) / 2, CV_32F);
      for (int r = 0; r < half.rows; ++r) {
        const float* const from = image.ptr<float>(2 * r);
        float* const to = half.ptr<float>(r);
        for (int c = 0; c < half.cols; ++c) to[c] = from[std::ptrdiff_t{2} * c];
      }
      image = half;
      step *= 2;
    }
    cv::Mat blurred;
    cv::GaussianBlur(image, blurred, {}, std::sqrt(next * next - sigma * sigma) / step, 0,
                     cv::BORDER_REPLICATE);
    image = blurred;
    sigma = next;
    if (sigma <= smallest) pyramid = {};
    pyramid.add(image, step, sigma);
  }
  return pyramid;
}

}  // namespace

PatchSift::PatchSift(const SiftOptions& options) : options_(options) { options_.check(); }

void PatchSift::describe(const cv::Mat& grey, int threads, Features& features) const {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const AffineFrame& frame : features.frames) {
    if (!isDescribable(frame, grey.size())) continue;
    const double blur = halfAxes(frame).smaller;
    smallest = std::min(smallest, blur);
    largest = std::max(largest, blur);
  }
  // A blur larger than the height or width of the image hardly changes it.
  const Pyramid pyramid =
      pyramidOf(grey, smallest, std::min<double>(largest, std::min(grey.cols, grey.rows)));
  const std::vector<char> described =
      siftDescriptors(pyramid.levels, features.frames, grey.size(), threads, features.descriptors);
  keepFeatures(described, features);
  if (options_.root) toRootSift(features.descriptors);
}

}  // namespace corrsel::core
