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
  // Even and odd rows have sums of their own, because a sum must wait for the one before.
  ByteProducts even_x, even_y, odd_x, odd_y;
  const auto pixels = [&patch](int row, int i) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(patch.first + row * patch.stride + i));
  };
  for (int i = 0; i < width; i += BytePatch::kBlock) {
    const std::int8_t *wx = x_weights + i, *wy = y_weights + i;
    for (int row = 0; row < patch.side; row += 2, wx += 2 * width, wy += 2 * width) {
      const __m256i even = pixels(row, i);
      even_x.add(even, wx);
      even_y.add(even, wy);
      if (row + 1 == patch.side) break;
      const __m256i odd = pixels(row + 1, i);
      odd_x.add(odd, wx + width);
      odd_y.add(odd, wy + width);
    }
  }
  return {even_x.total() + odd_x.total(), even_y.total() + odd_y.total()};
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

#if defined(__AVX512VBMI__)
constexpr int kSmallSide = 31;  // of the patches that fit into 16 registers

/// The tests of a patch in registers: a table of 1024 bytes, in which 64 places are looked up at a time.
void smallBinaryTests(const BytePatch& patch, const std::uint16_t* places, std::uint8_t* out) {
  __m512i table[16];
#pragma GCC unroll 16
  for (int i = 0; i < 16; ++i) {
    const auto row = [&](int number) {
      return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(patch.first + number * patch.stride));
    };
    const int second = 2 * i + 1 < kSmallSide ? 2 * i + 1 : 2 * i;
    // Masked, because GCC 12 takes the plain form's undefined source for a mistake.
    table[i] = _mm512_maskz_inserti64x4(static_cast<__mmask8>(-1), _mm512_castsi256_si512(row(2 * i)),
                                        row(second), 1);
  }
  for (int group = 0; group < 8; ++group, places += 64) {
    const __m512i low = _mm512_loadu_si512(places), high = _mm512_loadu_si512(places + 32);
    const auto bytes = [](__m512i a, __m512i b) {
      const __mmask32 all = ~__mmask32{0};
      return _mm512_maskz_inserti64x4(static_cast<__mmask8>(-1),
                                      _mm512_castsi256_si512(_mm512_maskz_cvtepi16_epi8(all, a)),
                                      _mm512_maskz_cvtepi16_epi8(all, b), 1);
    };
    const __m512i place = bytes(low, high);
    const __m512i upper = bytes(_mm512_srli_epi16(low, 7), _mm512_srli_epi16(high, 7));
    const auto bit = [&upper](char value) { return _mm512_test_epi8_mask(upper, _mm512_set1_epi8(value)); };
    const __mmask64 one = bit(1), two = bit(2), four = bit(4);
    __m512i found[8];
#pragma GCC unroll 8
    for (int i = 0; i < 8; ++i) found[i] = _mm512_permutex2var_epi8(table[2 * i], place, table[2 * i + 1]);
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) found[i] = _mm512_mask_blend_epi8(one, found[2 * i], found[2 * i + 1]);
#pragma GCC unroll 2
    for (int i = 0; i < 2; ++i) found[i] = _mm512_mask_blend_epi8(two, found[2 * i], found[2 * i + 1]);
    const __m512i pixels = _mm512_mask_blend_epi8(four, found[0], found[1]);
    // The first pixel of a test is in the lower half of 16 bits, the second one in the upper half.
    const __mmask32 bits = _mm512_cmplt_epu16_mask(_mm512_and_si512(pixels, _mm512_set1_epi16(0xff)),
                                                   _mm512_srli_epi16(pixels, 8));
    const std::uint32_t word = bits;
    __builtin_memcpy(out + 4 * group, &word, sizeof word);
  }
}
#endif

void binaryTestsKernel(const BytePatch& patch, const std::uint16_t* places, std::uint8_t* copy,
                       std::uint8_t* out) {
#if defined(__AVX512VBMI__)
  if (patch.side == kSmallSide) {
    smallBinaryTests(patch, places, out);
    return;
  }
#endif
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
