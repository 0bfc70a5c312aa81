#pragma once

#include "kernels/simd.h"
#include "kernels/view.h"

namespace corrsel::core {
namespace {

inline IntV gatherQuads(const std::uint32_t* quads, IntV offset) {
#if defined(__AVX512F__)
  return (IntV)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), static_cast<__mmask16>(-1),
                                           (__m512i)offset, quads, 4);
#elif defined(__AVX2__)
  return (IntV)_mm256_i32gather_epi32(reinterpret_cast<const int*>(quads), (__m256i)offset, 4);
#else
  IntV v;
  for (int k = 0; k < kWidth; ++k) v[k] = static_cast<std::int32_t>(quads[offset[k]]);
  return v;
#endif
}

void sampleLineKernel(const std::uint32_t* quads, std::ptrdiff_t stride, std::int32_t x, std::int32_t y,
                      std::int32_t dx, std::int32_t dy, int n, std::int16_t* out) {
  typedef std::int16_t OutputV __attribute__((vector_size(kWidth * 2)));
  IntV index;
  for (int k = 0; k < kWidth; ++k) index[k] = k;
  const IntV last = splat(static_cast<std::int32_t>(n - 1)), pitch = splat(static_cast<std::int32_t>(stride));
  for (int k = 0; k < n; k += kWidth, index += kWidth) {
    const IntV inside = index < last ? index : last;
    const IntV px = inside * dx + x, py = inside * dy + y;
    const IntV quad = gatherQuads(quads, (py >> 16) * pitch + (px >> 16));
    // Both rows of pixels side by side in 16 bits.
    const IntV right = (px >> 10) & 63, lower = (py >> 9) & 127;
    const IntV right_twice = right | (right << 16), left_twice = splat(64 * 0x10001) - right_twice;
    const ShortV rows = (ShortV)(quad & 0x00ff00ff) * (ShortV)left_twice +
                        (ShortV)((quad >> 8) & 0x00ff00ff) * (ShortV)right_twice;
    const IntV sum = addProducts(splat(32), (IntV)rows, (splat(128) - lower) | (lower << 16));
    const OutputV result = __builtin_convertvector(sum >> 6, OutputV);
    __builtin_memcpy(out + k, &result, sizeof result);
  }
}

}  // namespace
}  // namespace corrsel::core
