#pragma once

// Corners: many pixels of a row at a time.

#include "kernels/kernels.h"
#include "kernels/small_vectors.h"

namespace corrsel::core {
namespace {

/// Scores of kBytes pixels.
inline ByteV cornerScores(const std::uint8_t* centre, std::ptrdiff_t stride, ByteV threshold) {
  const auto at = [=](int x, int y) { return loadBytes(centre + y * stride + x); };
  const ByteV here = loadBytes(centre);
  ByteV ring[16];
  ring[0] = at(0, -3);
  ring[4] = at(3, 0);
  ring[8] = at(0, 3);
  ring[12] = at(-3, 0);
  // An arc of nine contains at least one of two opposite pixels.
  const ByteV high = minimum(maximum(ring[0], ring[8]), maximum(ring[4], ring[12]));
  const ByteV low = maximum(minimum(ring[0], ring[8]), minimum(ring[4], ring[12]));
  if (!anyNonZero(excess(maximum(excess(high, here), excess(here, low)), threshold))) return ByteV{};
  ring[1] = at(1, -3);
  ring[2] = at(2, -2);
  ring[3] = at(3, -1);
  ring[5] = at(3, 1);
  ring[6] = at(2, 2);
  ring[7] = at(1, 3);
  ring[9] = at(-1, 3);
  ring[10] = at(-2, 2);
  ring[11] = at(-3, 1);
  ring[13] = at(-3, -1);
  ring[14] = at(-2, -2);
  ring[15] = at(-1, -3);
  // The darkest pixel of the brightest arc, and the brightest one of the darkest arc. Two arcs of nine share
  // the eight pixels from an odd number on.
  ByteV dark_two[8], bright_two[8], dark_four[8], bright_four[8];
#pragma GCC unroll 8
  for (int i = 0; i < 8; ++i) {
    dark_two[i] = minimum(ring[2 * i + 1], ring[(2 * i + 2) % 16]);
    bright_two[i] = maximum(ring[2 * i + 1], ring[(2 * i + 2) % 16]);
  }
#pragma GCC unroll 8
  for (int i = 0; i < 8; ++i) {
    dark_four[i] = minimum(dark_two[i], dark_two[(i + 1) % 8]);
    bright_four[i] = maximum(bright_two[i], bright_two[(i + 1) % 8]);
  }
  ByteV brightest = ByteV{}, darkest = ~ByteV{};
#pragma GCC unroll 8
  for (int i = 0; i < 8; ++i) {
    const ByteV before = ring[2 * i], after = ring[(2 * i + 9) % 16];
    const ByteV dark = minimum(dark_four[i], dark_four[(i + 2) % 8]);
    const ByteV bright = maximum(bright_four[i], bright_four[(i + 2) % 8]);
    brightest = maximum(brightest, minimum(dark, maximum(before, after)));
    darkest = minimum(darkest, maximum(bright, minimum(before, after)));
  }
  const ByteV score = maximum(excess(brightest, here), excess(here, darkest));
  return score & (ByteV)(excess(score, threshold) != 0);
}

bool cornerScoresKernel(const std::uint8_t* row, std::ptrdiff_t stride, int n, int threshold,
                        std::uint8_t* scores) {
  const ByteV limit = splatByte(threshold);
  ByteV any = {};
  for (int x = 0; x < n; x += kBytes) {
    const ByteV score = cornerScores(row + x, stride, limit);
    storeBytes(scores + x, score);
    any |= score;
  }
  return anyNonZero(any);
}

int cornerMaximaKernel(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int n,
                       std::int32_t* columns) {
  int found = 0;
  for (int x = 0; x < n; x += kBytes) {
    const ByteV score = loadBytes(here + x);
    if (!anyNonZero(score)) continue;
    const ByteV before = maximum(maximum(loadBytes(above + x - 1), loadBytes(above + x)),
                                 maximum(loadBytes(above + x + 1), loadBytes(here + x - 1)));
    const ByteV after = maximum(maximum(loadBytes(below + x - 1), loadBytes(below + x)),
                                maximum(loadBytes(below + x + 1), loadBytes(here + x + 1)));
    // Above `before` and not below `after`: above both that and `after` less one.
    const ByteV one = splatByte(1);
    std::uint64_t bits = nonZeroBits(excess(score, maximum(before, excess(after, one))));
    if (n - x < kBytes) bits &= (std::uint64_t{1} << (n - x)) - 1;
    for (; bits != 0; bits &= bits - 1) columns[found++] = x + __builtin_ctzll(bits);
  }
  return found;
}

// Eight columns of 16-bit numbers, of which seven are used: the same at every level.
typedef std::int16_t EightV __attribute__((vector_size(16)));
typedef std::int32_t FourV __attribute__((vector_size(16)));

inline EightV widenEight(const std::uint8_t* p) {
#if defined(__SSE2__)
  return (EightV)_mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)), _mm_setzero_si128());
#elif defined(__ARM_NEON)
  return (EightV)vmovl_u8(vld1_u8(p));
#else
  EightV v;
  for (int k = 0; k < 8; ++k) v[k] = p[k];
  return v;
#endif
}

/// Adds products of neighbouring lanes: sum[i] += a[2 i] b[2 i] + a[2 i + 1] b[2 i + 1].
inline FourV addProducts(FourV sum, EightV a, EightV b) {
#if defined(__SSE2__)
  return sum + (FourV)_mm_madd_epi16((__m128i)a, (__m128i)b);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  const int16x8_t p = (int16x8_t)a, q = (int16x8_t)b;
  return sum + (FourV)vpaddq_s32(vmull_s16(vget_low_s16(p), vget_low_s16(q)), vmull_high_s16(p, q));
#else
  for (int k = 0; k < 4; ++k) sum[k] += a[2 * k] * b[2 * k] + a[2 * k + 1] * b[2 * k + 1];
  return sum;
#endif
}

inline std::int32_t sumOfFour(FourV v) { return (v[0] + v[1]) + (v[2] + v[3]); }

void structureKernel(const std::uint8_t* pixels, std::ptrdiff_t stride, const PixelPlace* places,
                     std::size_t n, StructureSums* sums) {
  constexpr int kRadius = 3;
  const EightV used = {-1, -1, -1, -1, -1, -1, -1, 0};
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t* p =
        pixels + (places[i].y - kRadius - 1) * stride + (places[i].x - kRadius - 1);  // of the upper left
    EightV difference[2 * kRadius + 3], mean[2 * kRadius + 3];                        // of the rows
#pragma GCC unroll 9
    for (int row = 0; row < 2 * kRadius + 3; ++row, p += stride) {
      const EightV left = widenEight(p), centre = widenEight(p + 1), right = widenEight(p + 2);
      difference[row] = right - left;
      mean[row] = left + right + (centre + centre);
    }
    FourV xx = {}, yy = {}, xy = {};
#pragma GCC unroll 7
    for (int row = 0; row < 2 * kRadius + 1; ++row) {
      const EightV dx = difference[row] + difference[row + 2] + (difference[row + 1] + difference[row + 1]);
      const EightV dy = mean[row + 2] - mean[row];
      const EightV used_dx = dx & used, used_dy = dy & used;
      xx = addProducts(xx, dx, used_dx);
      yy = addProducts(yy, dy, used_dy);
      xy = addProducts(xy, dx, used_dy);
    }
    sums[i] = {sumOfFour(xx), sumOfFour(yy), sumOfFour(xy)};
  }
}

}  // namespace
}  // namespace corrsel::core
