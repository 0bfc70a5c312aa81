#pragma once

// Counts of the matches that agree with a linear map.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

std::int32_t countKernel(const RelativeMatches& m, const float* a, float squared_limit) {
  IntV agreeing = {};
  for (std::size_t j = 0; j < m.slots; j += kWidth) {
    const FloatV x = load(m.left_x + j), y = load(m.left_y + j);
    const FloatV ex = a[0] * x + a[1] * y - load(m.right_x + j);
    const FloatV ey = a[2] * x + a[3] * y - load(m.right_y + j);
    agreeing -= ex * ex + ey * ey <= squared_limit;
  }
  return sum(agreeing);
}

std::size_t aroundSeedKernel(const FramedMatches& m, std::uint32_t begin, std::uint32_t end,
                             const FramedReach& reach, std::uint32_t* numbers) {
  std::size_t count = 0;
  IntV number = laneNumbers() + static_cast<std::int32_t>(begin);
  for (std::uint32_t j = begin; j < end; j += kWidth, number += kWidth) {
    const FloatV left_x = load(m.left_x + j) - reach.left_x, left_y = load(m.left_y + j) - reach.left_y;
    const FloatV right_x = load(m.right_x + j) - reach.right_x, right_y = load(m.right_y + j) - reach.right_y;
    const IntV near = (right_x * right_x + right_y * right_y < reach.squared_right) &
                      (left_x * left_x + left_y * left_y < reach.squared_left) &
                      (number < static_cast<std::int32_t>(end));
    if (!anyTrue(near)) continue;
    // Comparisons with NaN are false.
    const FloatV cosine = load(m.cosine + j) * reach.cosine + load(m.sine + j) * reach.sine;
    const IntV similar =
        (cosine >= reach.min_cosine) & (absolute(load(m.scale + j) - reach.scale) <= reach.max_scale);
    count += keep(near & similar, number, numbers + count);
  }
  return count;
}

}  // namespace
}  // namespace corrsel::core
