#pragma once

#include "kernels/orientation.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

/// kWidth 16-bit numbers as floats.
inline FloatV loadAsFloat(const std::int16_t* p) {
  typedef std::int16_t HalfV __attribute__((vector_size(kWidth * 2)));
  HalfV v;
  __builtin_memcpy(&v, p, sizeof v);
  return toFloat(__builtin_convertvector(v, IntV));
}

/// The direction of a gradient in turns, from 0 to 1, with an error below 3e-5. The polynomial for the first
/// octant is mirrored into the others.
inline FloatV turnsOf(FloatV dx, FloatV dy) {
  const FloatV zero{};
  const FloatV x = dx < zero ? -dx : dx, y = dy < zero ? -dy : dy;
  const FloatV t = minimum(x, y) / (maximum(x, y) + splat(1e-12F)), s = t * t;
  FloatV angle = t * (splat(0.15912117F) +
                      s * (splat(-0.05185401F) + s * (splat(0.02476110F) - splat(0.00705479F) * s)));
  angle = y > x ? splat(0.25F) - angle : angle;
  angle = dx < zero ? splat(0.5F) - angle : angle;
  return dy < zero ? splat(1.0F) - angle : angle;
}

void orientationKernel(const std::int16_t* window, std::ptrdiff_t stride, int columns, int rows,
                       const float* across, const float* down, float* bins) {
  static_assert(OrientationKernels::kLanes == kLanes);
  constexpr int kBins = OrientationKernels::kBins;
  // Neighbouring columns add to different sums, because one addition to a sum waits for the one before.
  constexpr int kSums = 8;
  alignas(64) float sums[kSums][kBins + 12] = {};
  for (int r = 0; r < rows; ++r) {
    const std::int16_t* const row = window + r * stride;
    for (int c = 0; c < columns; c += kLanes) {
      alignas(64) std::int32_t bin[kLanes];
      alignas(64) float weight[kLanes];
      for (int k = 0; k < kLanes; k += kWidth) {
        const std::int16_t* const p = row + c + k;
        const FloatV dx = loadAsFloat(p + 1) - loadAsFloat(p - 1);
        const FloatV dy = loadAsFloat(p + stride) - loadAsFloat(p - stride);
        const FloatV length = squareRoot(dx * dx + dy * dy);
        store(bin + k, truncate(turnsOf(dx, dy) * splat(float{kBins}) + splat(0.5F)));
        store(weight + k, length * load(across + c + k) * splat(down[r]));
      }
      const int n = columns - c < kLanes ? columns - c : kLanes;
      for (int k = 0; k < kSums; ++k) sums[k][bin[k]] += weight[k];
      if (n > kSums) {
        for (int k = 0; k < kSums; ++k) sums[k][bin[kSums + k]] += weight[kSums + k];
      }
    }
  }
  const auto total = [&sums](int k) {
    return ((sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k])) +
           ((sums[4][k] + sums[5][k]) + (sums[6][k] + sums[7][k]));
  };
  for (int k = 0; k < kBins; ++k) bins[k] = total(k);
  bins[0] += total(kBins);
}

}  // namespace
}  // namespace corrsel::core
