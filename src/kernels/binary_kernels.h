#pragma once

// Moments and comparisons of the pixels of a patch.

#include "kernels/kernels.h"
#include "kernels/small_vectors.h"

namespace corrsel::core {
namespace {

#if defined(__AVX2__)
/// Sums of eight lanes of products of bytes and signed bytes.
struct ByteProducts {
  __m256i sum = _mm256_setzero_si256();

  void add(__m256i pixels, const std::int8_t* weights) {
    const __m256i factors = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(weights));
#if defined(__AVX512VNNI__)
    sum = _mm256_dpbusd_epi32(sum, pixels, factors);
#else
    // No sum of two products exceeds 16 bits, because weights are at most 63.
    const __m256i pairs = _mm256_maddubs_epi16(pixels, factors);
    sum = _mm256_add_epi32(sum, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)));
#endif
  }

  std::int32_t total() const {
    __m128i four = _mm_add_epi32(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    four = _mm_add_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
    four = _mm_add_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(2, 3, 0, 1)));
    return _mm_cvtsi128_si32(four);
  }
};
#endif

Moments centroidKernel(const BytePatch& patch, const std::int8_t* x_weights, const std::int8_t* y_weights) {
  const int width = patch.blocks * BytePatch::kBlock;
#if defined(__AVX2__)
  ByteProducts x[2], y[2];
  for (int row = 0; row < patch.side; ++row) {
    for (int i = 0; i < width; i += BytePatch::kBlock) {
      const __m256i pixels =
          _mm256_loadu_si256(reinterpret_cast<const __m256i*>(patch.first + row * patch.stride + i));
      x[row % 2].add(pixels, x_weights + row * width + i);
      y[row % 2].add(pixels, y_weights + row * width + i);
    }
  }
  return {x[0].total() + x[1].total(), y[0].total() + y[1].total()};
#else
  std::int32_t x = 0, y = 0;
  for (int row = 0; row < patch.side; ++row) {
    const std::uint8_t* const pixels = patch.first + row * patch.stride;
    const std::int8_t *const wx = x_weights + row * width, *const wy = y_weights + row * width;
    for (int i = 0; i < width; ++i) {
      x += pixels[i] * wx[i];
      y += pixels[i] * wy[i];
    }
  }
  return {x, y};
#endif
}

void binaryTestsKernel(const BytePatch& patch, const std::uint16_t* places, std::uint8_t* copy,
                       std::uint8_t* out) {
  const int width = patch.blocks * BytePatch::kBlock;
  for (int row = 0; row < patch.side; ++row) {
    for (int i = 0; i < width; i += BytePatch::kBlock) {
      __builtin_memcpy(copy + row * width + i, patch.first + row * patch.stride + i, BytePatch::kBlock);
    }
  }
  for (int byte = 0; byte < 32; ++byte, places += 16) {
    unsigned bits = 0;
#pragma GCC unroll 8
    for (int bit = 7; bit >= 0; --bit) {
      bits = bits + bits + (copy[places[2 * bit]] < copy[places[2 * bit + 1]] ? 1U : 0U);
    }
    out[byte] = static_cast<std::uint8_t>(bits);
  }
}

}  // namespace
}  // namespace corrsel::core
