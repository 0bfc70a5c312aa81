#include "features/parts/oriented_patch.h"

#include <cmath>
#include <cstddef>

#include "features/descriptors/orb_pattern.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr int kMaxBytes = 128 * 127;  // of a copied patch

}  // namespace

// The polynomial approximates atan on [0, 1]: Abramowitz and Stegun, "Handbook of Mathematical Functions",
// 4.4.49, with an error below 2e-8 rad before rounding.
float angleOf(float x, float y) {
  const float a = std::abs(x), b = std::abs(y);
  const float larger = a > b ? a : b, smaller = a > b ? b : a;
  if (larger == 0) return 0;
  const float t = smaller / larger, s = t * t;
  float angle = 0.0028662257F;
  angle = angle * s - 0.0161657367F;
  angle = angle * s + 0.0429096138F;
  angle = angle * s - 0.0752896400F;
  angle = angle * s + 0.1065626393F;
  angle = angle * s - 0.1420889944F;
  angle = angle * s + 0.1999355085F;
  angle = angle * s - 0.3333314528F;
  angle = (angle * s + 1.0F) * t * static_cast<float>(180 / CV_PI);
  if (b > a) angle = 90 - angle;
  if (x < 0) angle = 180 - angle;
  if (y < 0) angle = 360 - angle;
  return angle < 360 ? angle : 0;
}

OrientedPatch::OrientedPatch(int patch_size)
    : radius_(patch_size / 2), blocks_((2 * radius_ + BytePatch::kBlock) / BytePatch::kBlock) {
  const int side = 2 * radius_ + 1, width = blocks_ * BytePatch::kBlock;
  x_weights_.assign(static_cast<std::size_t>(side * width), 0);
  y_weights_ = x_weights_;
  for (int y = -radius_; y <= radius_; ++y) {
    for (int x = -radius_; x <= radius_; ++x) {
      // All pixels whose distance is below radius + 1/2.
      if (x * x + y * y > radius_ * (radius_ + 1)) continue;
      const auto at = static_cast<std::size_t>((y + radius_) * width + x + radius_);
      x_weights_[at] = static_cast<std::int8_t>(x);
      y_weights_[at] = static_cast<std::int8_t>(y);
    }
  }
  places_.reserve(static_cast<std::size_t>(kDirections) * 2 * kOrbTests);
  const double scale = static_cast<double>(radius_) / kOrbRadius;
  for (int direction = 0; direction < kDirections; ++direction) {
    const auto add = [&](int x, int y) {
      const cv::Point place = turned(x * scale, y * scale, direction);
      places_.push_back(static_cast<std::uint16_t>((place.y + radius_) * width + place.x + radius_));
    };
    for (const OrbTest& test : kOrbPattern) {
      add(test.x1, test.y1);
      add(test.x2, test.y2);
    }
  }
}

cv::Point OrientedPatch::turned(double x, double y, int direction) {
  const double angle = direction * (2 * CV_PI / kDirections), c = std::cos(angle), s = std::sin(angle);
  // Halves are rounded alike where sines and cosines differ in their last bit.
  constexpr double kDownwards = 1e-9;
  const auto rounded = [](double value) { return static_cast<int>(std::floor(value + 0.5 - kDownwards)); };
  return {rounded(c * x - s * y), rounded(s * x + c * y)};
}

int OrientedPatch::numberOf(float angle) {
  const auto number = static_cast<int>(std::lround(angle * (kDirections / 360.0F)));
  return ((number % kDirections) + kDirections) % kDirections;
}

PatchDirection OrientedPatch::direction(const PyramidLevel& level, int x, int y) const {
  const BytePatch patch{level.pixels + (y - radius_) * level.stride + (x - radius_), level.stride,
                        2 * radius_ + 1, blocks_};
  const Moments moments = kernels().binary.moments(patch, x_weights_.data(), y_weights_.data());
  const auto mx = static_cast<float>(moments.x), my = static_cast<float>(moments.y);
  const float length = std::sqrt(mx * mx + my * my);
  if (length == 0) return {0, 1, 0};
  return {angleOf(mx, my), mx / length, my / length};
}

void OrientedPatch::describe(const PyramidLevel& blurred, int x, int y, float angle,
                             std::uint8_t* out) const {
  const BytePatch patch{blurred.pixels + (y - radius_) * blurred.stride + (x - radius_), blurred.stride,
                        2 * radius_ + 1, blocks_};
  alignas(64) std::uint8_t copy[kMaxBytes];
  kernels().binary.tests(patch, places_.data() + static_cast<std::size_t>(numberOf(angle)) * 2 * kOrbTests,
                         copy, out);
}

}  // namespace corrsel::core
