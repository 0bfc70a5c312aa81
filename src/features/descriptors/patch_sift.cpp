#include "features/descriptors/patch_sift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "base/parallel.h"
#include "features/parts/affine_patch.h"
#include "features/parts/feature_list.h"
#include "features/parts/gradient.h"
#include "features/parts/root_sift.h"

namespace corrsel::core {
namespace {

constexpr int kCells = 4, kDirections = 8, kLength = kCells * kCells * kDirections;
constexpr double kSpacing = 0.5;  // of the samples, in units of the frame
constexpr int kCellSamples = 6;   // samples along one side of a cell
constexpr int kHalf = 15;         // samples on each side of the centre
constexpr int kSide = 2 * kHalf + 1;
constexpr int kInner = kSide - 2;  // samples that have a gradient, and a weight in a cell
constexpr int kMiddle = kInner / 2;
constexpr double kWindow = 2.0 * kCellSamples;  // sigma of the Gaussian weight, samples

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

/// The cells to which the samples of one row or column contribute: cell `first` by 1 - share, the next one by
/// share.
struct Cell {
  int first;  // -1 .. 3; -1 and 4 are outside the descriptor
  float share;
};

struct Tables {
  std::array<Cell, kInner> cells;
  std::vector<float> window = gaussianWindow(kMiddle, 1, kWindow);

  Tables() {
    for (int i = 0; i < kInner; ++i) {
      // The middle of cell 0 is one and a half cells before the centre, that of cell -1 two and a half (kHalf
      // samples).
      const int sample = i - kMiddle + kHalf;
      cells[static_cast<std::size_t>(i)] = {sample / kCellSamples - 1,
                                            static_cast<float>(sample % kCellSamples) / kCellSamples};
    }
  }
};

/// The histogram of a patch before normalisation.
void histogramOf(const float* patch, const Tables& tables, float* histogram) {
  PatchGradients<kSide> gradients;
  gradients.compute(patch, kDirections);
  auto& [dx, dy, length, direction] = gradients;
  for (std::size_t i = 0; i < gradients.kCount; ++i) length[i] *= tables.window[i];

  std::fill(histogram, histogram + kLength, 0.0F);
  for (int r = 0; r < kInner; ++r) {
    // One row of cells, with an additional cell on both sides.
    float line[(kCells + 2) * kDirections] = {};
    for (int c = 0; c < kInner; ++c) {
      const auto i = static_cast<std::size_t>(r) * kInner + static_cast<std::size_t>(c);
      const Cell cell = tables.cells[static_cast<std::size_t>(c)];
      float* const left = line + (std::ptrdiff_t{cell.first} + 1) * kDirections;
      float* const right = left + kDirections;
      const int bin = static_cast<int>(direction[i]), low = bin % kDirections, high = (bin + 1) % kDirections;
      const float to_high = (direction[i] - static_cast<float>(bin)) * length[i],
                  to_low = length[i] - to_high;
      left[low] += to_low * (1 - cell.share);
      left[high] += to_high * (1 - cell.share);
      right[low] += to_low * cell.share;
      right[high] += to_high * cell.share;
    }
    const Cell cell = tables.cells[static_cast<std::size_t>(r)];
    for (int side = 0; side < 2; ++side) {
      const int target = cell.first + side;
      if (target < 0 || target >= kCells) continue;
      const float share = side == 0 ? 1 - cell.share : cell.share;
      float* const to = histogram + std::ptrdiff_t{target} * kCells * kDirections;
      for (int k = 0; k < kCells * kDirections; ++k) to[k] += share * line[kDirections + k];
    }
  }
}

/// Normalises a histogram in place to the values that describe() documents. Returns false where it is empty.
bool normalize(float* v) {
  const auto scaleToLength = [v](double length) {
    double sum = 0;
    for (int i = 0; i < kLength; ++i) sum += double{v[i]} * v[i];
    if (!(sum > 0)) return false;
    const auto factor = static_cast<float>(length / std::sqrt(sum));
    for (int i = 0; i < kLength; ++i) v[i] *= factor;
    return true;
  };
  if (!scaleToLength(1)) return false;
  for (int i = 0; i < kLength; ++i) v[i] = std::min(v[i], 0.2F);
  scaleToLength(512);
  for (int i = 0; i < kLength; ++i) v[i] = std::min(255.0F, std::floor(v[i] + 0.5F));
  return true;
}

bool describable(const AffineFrame& frame, const cv::Size& size) {
  for (const float value : frame) {
    if (!std::isfinite(value)) return false;
  }
  return size.width > 1 && size.height > 1 && frame[2] >= 0 && frame[5] >= 0 &&
         frame[2] <= static_cast<float>(size.width - 1) && frame[5] <= static_cast<float>(size.height - 1) &&
         halfAxes(frame).smaller > 0;
}

}  // namespace

PatchSift::PatchSift(const SiftOptions& options) : options_(options) { options_.check(); }

void PatchSift::describe(const cv::Mat& grey, int threads, Features& features) const {
  static const Tables tables;
  const std::size_t n = features.keypoints.size();
  std::vector<double> blur(n, 0.0);
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!describable(features.frames[i], grey.size())) continue;
    blur[i] = halfAxes(features.frames[i]).smaller;
    smallest = std::min(smallest, blur[i]);
    largest = std::max(largest, blur[i]);
  }
  // A blur larger than the height or width of the image hardly changes it.
  const Pyramid pyramid =
      pyramidOf(grey, smallest, std::min<double>(largest, std::min(grey.cols, grey.rows)));

  cv::Mat descriptors(static_cast<int>(n), kLength, CV_32F);
  std::vector<char> keep(n, 0);
  forEachBlock(n, 64, threads, [&](std::size_t begin, std::size_t end) {
    std::array<float, std::size_t{kSide} * kSide> patch;
    for (std::size_t i = begin; i < end; ++i) {
      if (!(blur[i] > 0)) continue;
      const std::size_t outside =
          samplePatch(levelFor(pyramid.levels, blur[i]), features.frames[i], kHalf, kSpacing, patch.data());
      if (2 * outside > patch.size()) continue;
      float* const descriptor = descriptors.ptr<float>(static_cast<int>(i));
      histogramOf(patch.data(), tables, descriptor);
      keep[i] = normalize(descriptor) ? 1 : 0;
    }
  });

  int kept = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!keep[i]) continue;
    if (kept != static_cast<int>(i)) descriptors.row(static_cast<int>(i)).copyTo(descriptors.row(kept));
    ++kept;
  }
  keepFeatures(keep, features);
  features.descriptors = kept == static_cast<int>(n) ? descriptors : descriptors.rowRange(0, kept).clone();
  if (options_.root) toRootSift(features.descriptors);
}

}  // namespace corrsel::core
