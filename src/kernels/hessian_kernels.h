#pragma once

// Determinant of the Hessian of a level and its extrema. Every value is computed by the same operations
// wherever it is in a vector.

#include "kernels/kernels.h"
#include "kernels/orientation_kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

inline void hessianResponsesKernel(const std::int16_t* above, const std::int16_t* row,
                                   const std::int16_t* below, int width, float factor, float* out) {
  const auto determinant = [factor](auto a, auto b, auto c, auto d, auto e, auto f, auto g, auto h, auto i) {
    const auto xx = d + f - 2.0F * e, yy = b + h - 2.0F * e;
    const auto xy = 0.25F * ((a + i) - (c + g));
    return factor * (xx * yy - xy * xy);
  };
  int x = 1;
  for (; x + kWidth <= width - 1; x += kWidth) {
    store(out + x,
          determinant(loadAsFloat(above + x - 1), loadAsFloat(above + x), loadAsFloat(above + x + 1),
                      loadAsFloat(row + x - 1), loadAsFloat(row + x), loadAsFloat(row + x + 1),
                      loadAsFloat(below + x - 1), loadAsFloat(below + x), loadAsFloat(below + x + 1)));
  }
  const auto at = [](const std::int16_t* p) { return static_cast<float>(*p); };
  for (; x < width - 1; ++x) {
    out[x] = determinant(at(above + x - 1), at(above + x), at(above + x + 1), at(row + x - 1), at(row + x),
                         at(row + x + 1), at(below + x - 1), at(below + x), at(below + x + 1));
  }
}

inline int hessianExtremaKernel(const float* const* rows, int begin, int end, float threshold,
                                std::int32_t* columns) {
  int found = 0;
  const float *const above = rows[0], *const row = rows[1], *const below = rows[2];
  const auto largest = [&](int x, auto load) {
    const auto sides = maximum(load(row + x - 1), load(row + x + 1));
    const auto up = maximum(maximum(load(above + x - 1), load(above + x)), load(above + x + 1));
    const auto down = maximum(maximum(load(below + x - 1), load(below + x)), load(below + x + 1));
    return maximum(sides, maximum(up, down));
  };
  const auto smallest = [&](int x, auto load) {
    const auto sides = minimum(load(row + x - 1), load(row + x + 1));
    const auto up = minimum(minimum(load(above + x - 1), load(above + x)), load(above + x + 1));
    const auto down = minimum(minimum(load(below + x - 1), load(below + x)), load(below + x + 1));
    return minimum(sides, minimum(up, down));
  };
  int x = begin;
  const auto wide = [](const float* p) { return load(p); };
  for (; x + kWidth <= end; x += kWidth) {
    const FloatV v = load(row + x);
    const IntV high = v >= threshold, low = v <= -threshold;
    if (!anyTrue(high | low)) continue;
    const IntV extremal = (high & (v > largest(x, wide))) | (low & (v < smallest(x, wide)));
    if (!anyTrue(extremal)) continue;
    for (int k = 0; k < kWidth; ++k) {
      columns[found] = x + k;
      found -= extremal[k];
    }
  }
  const auto single = [](const float* p) { return *p; };
  for (; x < end; ++x) {
    const float v = row[x];
    if ((v >= threshold && v > largest(x, single)) || (v <= -threshold && v < smallest(x, single))) {
      columns[found++] = x;
    }
  }
  return found;
}

}  // namespace
}  // namespace corrsel::core
