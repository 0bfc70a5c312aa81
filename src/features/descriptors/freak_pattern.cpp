#include "features/descriptors/freak_pattern.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace corrsel::core {
namespace {

constexpr std::size_t kRings = 7, kPerRing = 6, kTriangleRings = 4;
// Half side of the smallest box, px. A smaller box would average over less than bilinear interpolation does.
constexpr double kMinHalfSide = 0.5;
constexpr double kLevels = 16;  // steps per grey level

std::uint8_t fieldOf(std::size_t ring, std::size_t number) {
  return static_cast<std::uint8_t>(ring * kPerRing + number % kPerRing);
}

}  // namespace

std::array<FreakField, kFreakFields> freakPattern() {
  constexpr double kOuter = 2.0 / 3, kInner = 1.0 / 12, kUnit = (kOuter - kInner) / 21;
  constexpr double kRadius[kRings] = {kOuter,
                                      kOuter - 6 * kUnit,
                                      kOuter - 11 * kUnit,
                                      kOuter - 15 * kUnit,
                                      kOuter - 18 * kUnit,
                                      kOuter - 20 * kUnit,
                                      kInner};
  std::array<FreakField, kFreakFields> fields;
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    for (std::size_t i = 0; i < kPerRing; ++i) {
      const double angle = CV_PI / 6 * static_cast<double>(2 * i + ring % 2);
      fields[fieldOf(ring, i)] = {kRadius[ring] * std::cos(angle), kRadius[ring] * std::sin(angle),
                                  kRadius[ring] / 2};
    }
  }
  fields.back() = {0, 0, kInner / 2};
  return fields;
}

std::array<FreakPair, kFreakOrientationPairs> freakOrientationPairs() {
  std::array<FreakPair, kFreakOrientationPairs> pairs;
  std::size_t n = 0;
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    for (std::size_t i = 0; i < kPerRing / 2; ++i) pairs[n++] = {fieldOf(ring, i), fieldOf(ring, i + 3)};
    if (ring >= kTriangleRings) continue;
    for (std::size_t i = 0; i < kPerRing; ++i) pairs[n++] = {fieldOf(ring, i), fieldOf(ring, i + 2)};
  }
  return pairs;
}

std::vector<FreakPair> freakCandidatePairs() {
  std::vector<FreakPair> pairs;
  for (std::size_t a = 0; a < kFreakFields; ++a) {
    for (std::size_t b = a + 1; b < kFreakFields; ++b) {
      pairs.emplace_back(static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b));
    }
  }
  return pairs;
}

FreakSampler::FreakSampler(const cv::Mat& grey, double pattern_scale)
    : pattern_scale_(pattern_scale), width_(grey.cols), height_(grey.rows) {
  const std::size_t stride = static_cast<std::size_t>(width_) + 1;
  integral_.resize(stride * (static_cast<std::size_t>(height_) + 1));
  for (int y = 0; y < height_; ++y) {
    const auto* const pixels = grey.ptr<std::uint8_t>(y);
    const std::uint32_t* const above = integral_.data() + stride * static_cast<std::size_t>(y);
    std::uint32_t* const sums = integral_.data() + stride * (static_cast<std::size_t>(y) + 1);
    std::uint32_t row = 0;
    for (int x = 0; x < width_; ++x) {
      row += pixels[x];
      sums[x + 1] = above[x + 1] + row;
    }
  }
}

bool FreakSampler::fits(const cv::Point2f& position, double size) const {
  const FreakField& outer = fields_[0];
  const double scale = scaleOf(size), half = std::max(scale * outer.sigma, kMinHalfSide);
  // The image extends half a pixel beyond the centres of its outermost pixels.
  const double reach = scale * std::hypot(outer.x, outer.y) + half - 0.5;
  return size > 0 && 2 * half <= kMaxBox && position.x >= reach && position.y >= reach &&
         position.x <= width_ - 1 - reach && position.y <= height_ - 1 - reach;
}

float FreakSampler::boxMean(double x, double y, double half_side) const {
  // Begin and end of the box in columns and rows, clamped against rounding at the border.
  const double left = std::max(x - half_side + 0.5, 0.0), top = std::max(y - half_side + 0.5, 0.0);
  const double right = std::min(x + half_side + 0.5, static_cast<double>(width_));
  const double bottom = std::min(y + half_side + 0.5, static_cast<double>(height_));
  const int c0 = static_cast<int>(left), r0 = static_cast<int>(top);
  const int c1 = std::min(static_cast<int>(right), width_ - 1);
  const int r1 = std::min(static_cast<int>(bottom), height_ - 1);
  const double column0 = left - c0, column1 = right - c1, row0 = top - r0, row1 = bottom - r1;

  const std::size_t stride = static_cast<std::size_t>(width_) + 1;
  const std::uint32_t* const origin = integral_.data() + stride * static_cast<std::size_t>(r0) + c0;
  const std::size_t across = static_cast<std::size_t>(c1 - c0),
                    down = stride * static_cast<std::size_t>(r1 - r0);
  // Sum over the box's columns, from row r0 to the given one.
  const auto strip = [&](std::size_t row) {
    const std::uint32_t* const sums = origin + row;
    const auto from_origin = [&](std::size_t column) {
      return static_cast<double>(sums[column] - sums[0] - origin[column] + origin[0]);
    };
    return (1 - column1) * from_origin(across) + column1 * from_origin(across + 1) - column0 * from_origin(1);
  };
  const double sum = (1 - row1) * strip(down) + row1 * strip(down + stride) - row0 * strip(stride);
  const double mean = sum / ((right - left) * (bottom - top));
  return static_cast<float>(std::floor(mean * kLevels + 0.5) / kLevels);
}

FreakSampler::Means FreakSampler::means(const cv::Point2f& position, double size, double angle) const {
  const double scale = scaleOf(size), c = scale * std::cos(angle), s = scale * std::sin(angle);
  Means means;
  for (std::size_t i = 0; i < kFreakFields; ++i) {
    const FreakField& field = fields_[i];
    means[i] = boxMean(position.x + c * field.x - s * field.y, position.y + s * field.x + c * field.y,
                       std::max(scale * field.sigma, kMinHalfSide));
  }
  return means;
}

double FreakSampler::orientation(const cv::Point2f& position, double size) const {
  const Means levels = means(position, size, 0);
  double x = 0, y = 0;
  for (const auto& [a, b] : orientation_pairs_) {
    const double dx = fields_[a].x - fields_[b].x, dy = fields_[a].y - fields_[b].y;
    const double slope = static_cast<double>(levels[a] - levels[b]) / std::hypot(dx, dy);
    x += slope * dx;
    y += slope * dy;
  }
  return std::atan2(y, x);
}

}  // namespace corrsel::core
