#pragma once

// Reduction and blur of images of 8 bits: rows of 16-bit numbers.

#include "kernels/kernels.h"
#include "kernels/small_vectors.h"

namespace corrsel::core {
namespace {

/// The columns of one group.
inline void shrinkGroup(const std::uint8_t* p, const std::uint8_t* places, const std::uint8_t* weights,
                        std::int16_t* out) {
  for (int i = 0; i < ShrinkColumns::kGroup; ++i) {
    out[i] = static_cast<std::int16_t>(p[places[2 * i]] * weights[2 * i] +
                                       p[places[2 * i + 1]] * weights[2 * i + 1]);
  }
}

void shrinkColumnsKernel(const std::uint8_t* row, const ShrinkColumns& columns, std::int16_t* out) {
  int group = 0;
#if defined(__AVX2__)
  if (columns.narrow) {
    for (; group < columns.groups; group += 2) {
      const auto pixels = [&](int g) {
        return _mm_loadu_si128(reinterpret_cast<const __m128i*>(row + columns.first[g]));
      };
      const __m256i both =
          _mm256_inserti128_si256(_mm256_castsi128_si256(pixels(group)), pixels(group + 1), 1);
      const auto table = [&](const std::uint8_t* values) {
        return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(values + 16 * group));
      };
      const __m256i pairs = _mm256_shuffle_epi8(both, table(columns.places));
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + group * ShrinkColumns::kGroup),
                          _mm256_maddubs_epi16(pairs, table(columns.weights)));
    }
  }
#endif
  for (; group < columns.groups; ++group) {
    shrinkGroup(row + columns.first[group], columns.places + 16 * group, columns.weights + 16 * group,
                out + group * ShrinkColumns::kGroup);
  }
}

void shrinkRowsKernel(const std::int16_t* top, const std::int16_t* bottom, std::int16_t weight, int n,
                      std::uint8_t* out) {
  for (int x = 0; x < n; x += kShorts) {
    const ShortV above = load(top + x), below = load(bottom + x);
    const ShortV difference = below - above;
    const ShortV value = above + highProduct(difference + difference, weight);
    narrow(out + x, (UShortV)((value + 32) >> 6));
  }
}

void smoothRowsKernel(const std::uint8_t* first, std::ptrdiff_t stride, int n, std::uint16_t* out) {
  for (int x = 0; x < n; x += kShorts) {
    const std::uint8_t* const p = first + x;
    const auto pair = [=](int a, int b) { return widen(p + a * stride) + widen(p + b * stride); };
    store(out + x, widen(p + 3 * stride) * 28 + pair(2, 4) * 24 + (pair(1, 5) * 17 + pair(0, 6) * 9));
  }
}

void smoothColumnsKernel(const std::uint16_t* sums, int n, std::uint8_t* out) {
  for (int x = 0; x < n; x += kShorts) {
    const std::uint16_t* const p = sums + x;
    const auto pair = [=](int a, int b) { return load(p + a) + load(p + b); };
    // The weights sum up to 2^16; every product loses half a unit of 1 / 128 grey level on average.
    const UShortV value = (highProduct(load(p + 3), 14162) + highProduct(pair(2, 4), 12498)) +
                          (highProduct(pair(1, 5), 8590) + highProduct(pair(0, 6), 4599));
    narrow(out + x, (value + 66) >> 7);
  }
}

}  // namespace
}  // namespace corrsel::core
