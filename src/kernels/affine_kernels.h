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

}  // namespace
}  // namespace corrsel::core
