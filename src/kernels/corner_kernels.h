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

constexpr int kBlocks = kBytes / 16;  ///< of 16 bytes in a vector, for a patch each

/// 16 bytes each from several places.
inline ByteV loadBlocks(const std::uint8_t* const (&places)[kBlocks]) {
#if defined(__AVX512F__) || defined(__AVX2__)
  const auto block = [&](int i) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(places[i])); };
  const auto pair = [&](int i) {
    return _mm256_inserti128_si256(_mm256_castsi128_si256(block(i)), block(i + 1), 1);
  };
#if defined(__AVX512F__)
  // Masked, because GCC 12 takes the plain form's undefined source for a mistake.
  return (ByteV)_mm512_maskz_inserti64x4(static_cast<__mmask8>(-1), _mm512_castsi256_si512(pair(0)), pair(2),
                                         1);
#else
  return (ByteV)pair(0);
#endif
#else
  return loadBytes(places[0]);
#endif
}

/// The bytes first to first + 7 of every block.
template <int kFirst>
inline ShortV eightOfBlocks(ByteV v) {
#if defined(__AVX512F__)
  return (ShortV)_mm512_unpacklo_epi8(_mm512_bsrli_epi128((__m512i)v, kFirst), _mm512_setzero_si512());
#elif defined(__AVX2__)
  return (ShortV)_mm256_unpacklo_epi8(_mm256_srli_si256((__m256i)v, kFirst), _mm256_setzero_si256());
#elif defined(__SSE2__)
  return (ShortV)_mm_unpacklo_epi8(_mm_srli_si128((__m128i)v, kFirst), _mm_setzero_si128());
#elif defined(__ARM_NEON)
  return (ShortV)vmovl_u8(vget_low_u8(vextq_u8((uint8x16_t)v, (uint8x16_t)v, kFirst)));
#else
  ShortV result;
  for (int k = 0; k < 8; ++k) result[k] = v[k + kFirst];
  return result;
#endif
}

void structureKernel(const std::uint8_t* pixels, std::ptrdiff_t stride, const PixelPlace* places,
                     std::size_t n, StructureSums* sums) {
  constexpr int kSide = 7;  // of the block; its derivatives need one more pixel on each side
  const ShortV used = [] {
    ShortV lanes;  // of eight columns, seven are used
    for (int k = 0; k < kShorts; ++k) lanes[k] = k % 8 < kSide ? -1 : 0;
    return lanes;
  }();
  for (std::size_t begin = 0; begin < n; begin += kBlocks) {
    const std::uint8_t* corners[kBlocks];
    for (int i = 0; i < kBlocks; ++i) {
      const PixelPlace& place = places[begin + i < n ? begin + i : begin];
      corners[i] = pixels + (place.y - kSide / 2 - 1) * stride + (place.x - kSide / 2 - 1);
    }
    ShortV difference[kSide + 2], mean[kSide + 2];  // of the rows
#pragma GCC unroll 9
    for (int row = 0; row < kSide + 2; ++row) {
      const ByteV bytes = loadBlocks(corners);
      const ShortV left = eightOfBlocks<0>(bytes), centre = eightOfBlocks<1>(bytes),
                   right = eightOfBlocks<2>(bytes);
      difference[row] = right - left;
      mean[row] = left + right + (centre + centre);
      for (int i = 0; i < kBlocks; ++i) corners[i] += stride;
    }
    IntV xx = {}, yy = {}, xy = {};
#pragma GCC unroll 7
    for (int row = 0; row < kSide; ++row) {
      const ShortV dx = difference[row] + difference[row + 2] + (difference[row + 1] + difference[row + 1]);
      const ShortV dy = mean[row + 2] - mean[row];
      const ShortV used_dx = dx & used, used_dy = dy & used;
      xx = addProducts(xx, (IntV)dx, (IntV)used_dx);
      yy = addProducts(yy, (IntV)dy, (IntV)used_dy);
      xy = addProducts(xy, (IntV)dx, (IntV)used_dy);
    }
    std::int32_t lanes[3][kWidth];
    store(lanes[0], xx);
    store(lanes[1], yy);
    store(lanes[2], xy);
    for (int i = 0; i < kBlocks && begin + i < n; ++i) {
      const auto total = [i](const std::int32_t* v) {
        return (v[4 * i] + v[4 * i + 1]) + (v[4 * i + 2] + v[4 * i + 3]);
      };
      sums[begin + i] = {total(lanes[0]), total(lanes[1]), total(lanes[2])};
    }
  }
}

}  // namespace
}  // namespace corrsel::core
