#pragma once

// Sampling and gradient histograms of the patch around a feature. Whole numbers are summed exactly, and other
// sums have a fixed order, so that all levels give the same bits.

#include "kernels/kernels.h"
#include "kernels/orientation_kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

typedef std::uint16_t HalfV __attribute__((vector_size(kWidth * 4)));
typedef float Float4 __attribute__((vector_size(16)));

/// Two neighbouring pixels per lane, the left one in the lower half.
inline IntV neighbours(const std::int16_t* pixels, IntV offset) {
#if defined(__AVX512F__)
  return (IntV)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), static_cast<__mmask16>(-1),
                                           (__m512i)offset, pixels, 2);
#else
  alignas(64) std::int32_t at[kWidth];
  store(at, offset);
  const auto pair = [&](int k) {
    std::int32_t value;
    __builtin_memcpy(&value, pixels + at[k], sizeof value);
    return value;
  };
#if defined(__AVX2__)
  // Single loads take less time than a gather of eight.
  const auto four = [&](int k) {
    __m128i v = _mm_cvtsi32_si128(pair(k));
    v = _mm_insert_epi32(v, pair(k + 1), 1);
    v = _mm_insert_epi32(v, pair(k + 2), 2);
    return _mm_insert_epi32(v, pair(k + 3), 3);
  };
  return (IntV)_mm256_inserti128_si256(_mm256_castsi128_si256(four(0)), four(4), 1);
#elif defined(__SSE2__)
  const __m128i low = _mm_unpacklo_epi32(_mm_cvtsi32_si128(pair(0)), _mm_cvtsi32_si128(pair(1)));
  const __m128i high = _mm_unpacklo_epi32(_mm_cvtsi32_si128(pair(2)), _mm_cvtsi32_si128(pair(3)));
  return (IntV)_mm_unpacklo_epi64(low, high);
#else
  return IntV{pair(0), pair(1), pair(2), pair(3)};
#endif
#endif
}

template <bool clamped>
inline int sampleRows(const PatchGrid& g, Patch& patch) {
  constexpr int kWeightBits = 14, kOne = 1 << kWeightBits;
  alignas(64) std::int32_t across_x[Patch::kPitch], across_y[Patch::kPitch], counted[Patch::kPitch];
  for (int c = 0; c < Patch::kPitch; ++c) {
    const int column = c < Patch::kSide ? c : Patch::kSide - 1;
    across_x[c] = column * g.across_x;
    across_y[c] = column * g.across_y;
    counted[c] = c < Patch::kSide ? 1 : 0;
  }
  const IntV steps = splat(static_cast<std::int32_t>(g.stride * 65536 + 1));
  IntV outside = splat(0);
  float* out = patch.values;
  for (int r = 0; r < Patch::kSide; ++r) {
    const IntV row_x = splat(g.x + r * g.down_x), row_y = splat(g.y + r * g.down_y);
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      IntV x = row_x + load(across_x + c), y = row_y + load(across_y + c);
      IntV column, row;
      if (clamped) {
        const IntV inside_x = minimum(maximum(x, splat(0)), splat((g.width - 1) * 65536));
        const IntV inside_y = minimum(maximum(y, splat(0)), splat((g.height - 1) * 65536));
        outside += ((inside_x != x) | (inside_y != y)) & load(counted + c);
        // In the last column and row the pixel before has the weight 0.
        column = minimum(inside_x >> 16, splat(g.width - 2));
        row = minimum(inside_y >> 16, splat(g.height - 2));
        x = inside_x - (column << 16);
        y = inside_y - (row << 16);
      } else {
        column = x >> 16;
        row = y >> 16;
        x &= 0xffff;
        y &= 0xffff;
      }
      const IntV offset = addProducts(splat(0), (row << 16) | column, steps);
      const IntV right = x >> (16 - kWeightBits), lower = y >> (16 - kWeightBits);
      const IntV across = (right << 16) - right + kOne, down = (lower << 16) - lower + kOne;
      const IntV top = addProducts(splat(kOne / 2), neighbours(g.pixels, offset), across) >> kWeightBits;
      const IntV bottom =
          addProducts(splat(kOne / 2), neighbours(g.pixels + g.stride, offset), across) >> kWeightBits;
      const IntV sum = addProducts(splat(0), top | (bottom << 16), down);
      store(out + c, toFloat(sum) * (1.0F / (128 * kOne)));
    }
    out += Patch::kPitch;
  }
  for (int i = 0; i < Patch::kBeyond; ++i) out[i] = 0;
  return clamped ? sum(outside) : 0;
}

inline void samplePatchKernel(const PatchGrid& grid, Patch& patch) { sampleRows<false>(grid, patch); }
inline int sampleClampedKernel(const PatchGrid& grid, Patch& patch) { return sampleRows<true>(grid, patch); }

inline void blurRowsKernel(const float* half, int reach, Patch& patch) {
  constexpr int kReach = PatchKernels::kMaxReach, kPadded = kReach + Patch::kPitch + kReach;
  // All rows are copied first, because a load waits where it overlaps with stores shortly before it.
  alignas(64) float padded[Patch::kSide * kPadded];
  for (int r = 0; r < Patch::kSide; ++r) {
    const float* const row = patch.values + r * Patch::kPitch;
    float* const to = padded + r * kPadded;
    const FloatV first = splat(row[0]), last = splat(row[Patch::kSide - 1]);
    for (int k = 0; k < kReach; k += kWidth)
      __builtin_memcpy(to + k, &first, (kWidth < kReach ? kWidth : kReach) * sizeof(float));
    for (int c = 0; c < Patch::kPitch; c += kWidth) store(to + kReach + c, load(row + c));
    for (int k = 0; k < kReach; k += kWidth) {
      __builtin_memcpy(to + kReach + Patch::kPitch + k, &last,
                       (kWidth < kReach ? kWidth : kReach) * sizeof(float));
    }
  }
  for (int r = 0; r < Patch::kSide; ++r) {
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      const float* const middle = padded + r * kPadded + kReach + c;
      FloatV sum = half[0] * load(middle);
      for (int k = 1; k <= reach; ++k) sum += half[k] * (load(middle - k) + load(middle + k));
      store(patch.values + r * Patch::kPitch + c, sum);
    }
    patch.values[r * Patch::kPitch + Patch::kSide] = patch.values[r * Patch::kPitch + Patch::kSide - 1];
  }
}

inline void blurColumnsKernel(const float* half, int reach, Patch& patch) {
  constexpr int kReach = PatchKernels::kMaxReach, kRows = Patch::kSide + 2 * kReach;
  for (int c = 0; c < Patch::kPitch; c += kWidth) {
    FloatV column[kRows];
    for (int r = 0; r < kRows; ++r) {
      const int row = r < kReach ? 0 : r - kReach < Patch::kSide ? r - kReach : Patch::kSide - 1;
      column[r] = load(patch.values + row * Patch::kPitch + c);
    }
    for (int r = 0; r < Patch::kSide; ++r) {
      const FloatV* const middle = column + kReach + r;
      FloatV sum = half[0] * middle[0];
      for (int k = 1; k <= reach; ++k) sum += half[k] * (middle[-k] + middle[k]);
      store(patch.values + r * Patch::kPitch + c, sum);
    }
  }
}

/// The sum of kLanes lanes in an order that is the same at every level.
inline float sumOfLanes(const FloatV* parts) {
  Float4 q[4];
  __builtin_memcpy(q, parts, sizeof q);
  const Float4 s = (q[0] + q[2]) + (q[1] + q[3]);
  return (s[0] + s[2]) + (s[1] + s[3]);
}

/// The gradients of kWidth samples that begin at the inner sample (row, column).
struct GradientV {
  FloatV dx, dy;

  GradientV(const Patch& patch, int row, int column) {
    const float* const p = patch.values + (row + 1) * Patch::kPitch + column + 1;
    dx = load(p + 1) - load(p - 1);
    dy = load(p + Patch::kPitch) - load(p - Patch::kPitch);
  }

  FloatV length() const { return squareRoot(dx * dx + dy * dy); }

  /// In turns, from 0 to 1, counted from +x to +y.
  FloatV direction() const { return turnsOf(dx, dy); }
};

inline GradientMoments momentsKernel(const Patch& patch, const PatchWeights& window) {
  FloatV xx[kParts] = {}, xy[kParts] = {}, yy[kParts] = {};
  for (int r = 0; r < Patch::kInner; ++r) {
    for (int c = 0; c < Patch::kPitch; c += kLanes) {
      for (int part = 0; part < kParts; ++part) {
        const int column = c + part * kWidth;
        const GradientV g(patch, r, column);
        const FloatV weight = load(window.values + r * Patch::kPitch + column);
        const FloatV wx = weight * g.dx, wy = weight * g.dy;
        xx[part] += wx * g.dx;
        xy[part] += wx * g.dy;
        yy[part] += wy * g.dy;
      }
    }
  }
  return {sumOfLanes(xx), sumOfLanes(xy), sumOfLanes(yy)};
}

/// Rows of a patch, added up with their mirror images about the middle row.
struct FoldedPatch {
  alignas(64) float rows[Patch::kHalf + 1][Patch::kPitch];

  void filter(const PatchFilters& filters, float* sums) const {
    for (int k = 0; k < PatchFilters::kCount; ++k) {
      FloatV parts[kParts] = {};
      for (int r = 0; r <= Patch::kHalf; ++r) {
        for (int c = 0; c < Patch::kPitch; c += kWidth) {
          parts[c % kLanes / kWidth] += load(rows[r] + c) * load(filters.values[k][r] + c);
        }
      }
      sums[k] = sumOfLanes(parts);
    }
  }
};

inline void filterPatchKernel(const Patch& patch, const PatchFilters& filters, float* sums) {
  FoldedPatch folded;
  for (int r = 0; r <= Patch::kHalf; ++r) {
    const float* const above = patch.values + (Patch::kHalf - r) * Patch::kPitch;
    const float* const below = patch.values + (Patch::kHalf + r) * Patch::kPitch;
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      store(folded.rows[r] + c, r == 0 ? load(above + c) : load(above + c) + load(below + c));
    }
  }
  folded.filter(filters, sums);
}

inline void filterUprightKernel(const PatchGrid& g, const PatchFilters& filters, float* sums) {
  constexpr int kWeightBits = 14, kOne = 1 << kWeightBits;
  constexpr int kMaxColumns = (Patch::kSide - 1) * (PatchKernels::kMaxUpright >> 16) + 3;
  const std::int32_t step = g.across_x;
  const int first = g.x >> 16, columns = ((g.x + (Patch::kSide - 1) * step) >> 16) + 2 - first;
  alignas(64) std::int32_t offset[Patch::kPitch], across[Patch::kPitch];
  for (int c = 0; c < Patch::kPitch; ++c) {
    const std::int32_t x = g.x + (c < Patch::kSide ? c : Patch::kSide - 1) * step - first * 65536;
    const std::int32_t right = (x & 0xffff) >> (16 - kWeightBits);
    offset[c] = x >> 16;
    across[c] = right * 65536 + (kOne - right);
  }
  const std::int32_t middle = g.y + Patch::kHalf * step;
  FoldedPatch folded;
  // Both are filled one row ahead, because loads wait where they overlap with stores shortly before them.
  alignas(64) std::int16_t lines[2][kMaxColumns + kShorts];
  for (int r = 0; r <= Patch::kHalf + 1; ++r) {
    if (r <= Patch::kHalf) {
      // The mean of the rows at the same distance from the middle row, each between two rows of pixels.
      const std::int32_t y[2] = {middle - r * step, middle + r * step};
      const std::int16_t* rows[2];
      IntV down[2];
      for (int side = 0; side < 2; ++side) {
        const std::int32_t lower = (y[side] & 0xffff) >> (17 - kWeightBits);
        rows[side] = g.pixels + (y[side] >> 16) * g.stride + first;
        down[side] = splat(lower * 65536 + (kOne / 2 - lower));
      }
      for (int x = 0; x < columns; x += kShorts) {
        IntV low = splat(kOne / 2), high = low;
        for (int side = 0; side < 2; ++side) {
          const ShortV upper = load(rows[side] + x), lower = load(rows[side] + g.stride + x);
          low = addProducts(low, (IntV)interleaveLow(upper, lower), down[side]);
          high = addProducts(high, (IntV)interleaveHigh(upper, lower), down[side]);
        }
        store(lines[r % 2] + x, narrow(low >> kWeightBits, high >> kWeightBits));
      }
    }
    if (r == 0) continue;
    const float unit = (r == 1 ? 1.0F : 2.0F) / (128 * kOne);
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      const IntV pairs = neighbours(lines[(r - 1) % 2], load(offset + c));
      store(folded.rows[r - 1] + c, toFloat(addProducts(splat(0), pairs, load(across + c))) * unit);
    }
  }
  folded.filter(filters, sums);
}

/// The difference of the largest and the smallest sample.
inline float contrast(const Patch& patch) {
  FloatV low = load(patch.values), high = low;
  for (int i = kWidth; i < Patch::kSide * Patch::kPitch; i += kWidth) {
    const FloatV v = load(patch.values + i);
    low = minimum(low, v);
    high = maximum(high, v);
  }
  float least = low[0], most = high[0];
  for (int k = 1; k < kWidth; ++k) {
    least = low[k] < least ? low[k] : least;
    most = high[k] > most ? high[k] : most;
  }
  return most - least;
}

inline HalfV splatHalf(int value) { return static_cast<std::uint16_t>(value) - HalfV{}; }

/// width - |t - centre| per 16-bit lane, where t and centre are on a circle of 2^16, or 0 where this is
/// negative.
inline HalfV tent(HalfV t, HalfV centre, HalfV width) {
  const HalfV d = t - centre;
#if defined(__AVX512F__)
  return (HalfV)_mm512_subs_epu16((__m512i)width, _mm512_abs_epi16((__m512i)d));
#elif defined(__AVX2__)
  return (HalfV)_mm256_subs_epu16((__m256i)width, _mm256_abs_epi16((__m256i)d));
#elif defined(__SSE2__)
  const __m128i distance = _mm_max_epi16((__m128i)d, _mm_sub_epi16(_mm_setzero_si128(), (__m128i)d));
  return (HalfV)_mm_subs_epu16((__m128i)width, distance);
#else
  const HalfV other = -d, distance = d < other ? d : other;
  return distance < width ? width - distance : HalfV{};
#endif
}

/// On a circle of 2^16.
inline IntV wholeDirection(const GradientV& g) { return truncate(g.direction() * 65536.0F + 0.5F); }

/// Two numbers of 16 bits in every lane.
inline IntV inOneLane(IntV low, IntV high) { return (low & 0xffff) | (high << 16); }

inline void directionsKernel(const Patch& patch, const PatchWeights& window, DirectionCounts& counts) {
  constexpr int kBins = DirectionCounts::kBins, kWidthOfBin = 65536 / kBins, kPlanes = 4;
  constexpr int kPairs = (Patch::kInner + 3) / 4, kLonger = kPairs * Patch::kPitch;
  const float range = contrast(patch);
  // The patch is smooth, so every second row suffices.
  // A gradient is at most sqrt(2) times as long as the contrast, so lengths are at most 2^12. The sum of a
  // bin is below 2^31 where the weights add up to at most 280.
  const float unit = range > 0 ? 2896.0F / range : 0.0F;
  // Two rows per lane.
  alignas(64) std::int32_t direction[kLonger], length[kLonger];
  for (int pair = 0; pair < kPairs; ++pair) {
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      IntV t[2] = {}, l[2] = {};
      for (int side = 0; side < 2; ++side) {
        const int row = 4 * pair + 2 * side;
        if (row >= Patch::kInner) continue;
        const GradientV g(patch, row, c);
        t[side] = wholeDirection(g);
        l[side] = truncate(g.length() * (unit * load(window.values + row * Patch::kPitch + c)) + 0.5F);
      }
      store(direction + pair * Patch::kPitch + c, inOneLane(t[0], t[1]));
      store(length + pair * Patch::kPitch + c, inOneLane(l[0], l[1]));
    }
  }
  for (int bin = 0; bin < kBins; bin += kPlanes) {
    HalfV centres[kPlanes];
    IntV sums[kPlanes] = {};
    for (int k = 0; k < kPlanes; ++k) centres[k] = splatHalf(((bin + k) * 65536 + kBins / 2) / kBins);
    for (int i = 0; i < kLonger; i += kWidth) {
      const HalfV t = (HalfV)load(direction + i);
      const IntV l = load(length + i);
      for (int k = 0; k < kPlanes; ++k) {
        sums[k] = addProducts(sums[k], (IntV)tent(t, centres[k], splatHalf(kWidthOfBin)), l);
      }
    }
    for (int k = 0; k < kPlanes; ++k) counts.bins[bin + k] = static_cast<float>(sum(sums[k]));
  }
}

/// Gradients of a band of rows, two rows per lane: the upper one in the lower half.
struct GradientBand {
  static constexpr int kPairs = CellTables::kCellSamples / 2;

  alignas(64) std::int32_t direction[kPairs][Patch::kPitch];  ///< 2^16 is a full turn
  alignas(64) std::int32_t before[kPairs][Patch::kPitch];     ///< lengths times the share of the cell before
  alignas(64) std::int32_t after[kPairs][Patch::kPitch];      ///< and of the cell after the row

  /// @param unit  of the lengths
  void fill(const Patch& patch, const CellTables& tables, int band, float unit) {
    for (int pair = 0; pair < kPairs; ++pair) {
      for (int c = 0; c < Patch::kPitch; c += kWidth) {
        IntV t[2], a[2], b[2];
        for (int side = 0; side < 2; ++side) {
          const int row = band * CellTables::kCellSamples + 2 * pair + side;
          const GradientV g(patch, row == 0 ? 0 : row - 1, c);
          const FloatV length = unit * g.length();
          t[side] = wholeDirection(g);
          a[side] = truncate(length * load(tables.rows[row][0] + c) + 0.5F);
          b[side] = truncate(length * load(tables.rows[row][1] + c) + 0.5F);
        }
        store(direction[pair] + c, inOneLane(t[0], t[1]));
        store(before[pair] + c, inOneLane(a[0], a[1]));
        store(after[pair] + c, inOneLane(b[0], b[1]));
      }
    }
  }
};

/// The shares of the columns in a cell times their sums, added up to four lanes.
template <int cell>
inline Float4 pooled(const std::int32_t* sums, const CellTables& tables) {
  // The first and the last column of the cell.
  constexpr int kFirst = CellTables::kCellSamples * cell - 1,
                kLast = kFirst + 2 * CellTables::kCellSamples - 1;
  FloatV parts[kParts] = {};
  for (int c = 0; c < Patch::kPitch; c += kWidth) {
    if (c > kLast || c + kWidth <= kFirst) continue;  // adds only zeros
    parts[c % kLanes / kWidth] += toFloat(load(sums + c)) * load(tables.columns[cell] + c);
  }
  Float4 q[4];
  __builtin_memcpy(q, parts, sizeof q);
  return (q[0] + q[2]) + (q[1] + q[3]);
}

/// The sum of the lanes of each argument.
inline Float4 sumsOfLanes(Float4 a, Float4 b, Float4 c, Float4 d) {
#if defined(__SSE2__)
  const __m128 ab = _mm_add_ps(_mm_unpacklo_ps((__m128)a, (__m128)b), _mm_unpackhi_ps((__m128)a, (__m128)b));
  const __m128 cd = _mm_add_ps(_mm_unpacklo_ps((__m128)c, (__m128)d), _mm_unpackhi_ps((__m128)c, (__m128)d));
  return (Float4)_mm_add_ps(_mm_movelh_ps(ab, cd), _mm_movehl_ps(cd, ab));
#else
  const auto total = [](Float4 v) { return (v[0] + v[2]) + (v[1] + v[3]); };
  return Float4{total(a), total(b), total(c), total(d)};
#endif
}

template <int cell>
inline void poolColumns(const std::int32_t (*sums)[Patch::kPitch], const CellTables& tables, float* out) {
  for (int k = 0; k < CellTables::kDirections; k += 4) {
    const Float4 four = sumsOfLanes(pooled<cell>(sums[k], tables), pooled<cell>(sums[k + 1], tables),
                                    pooled<cell>(sums[k + 2], tables), pooled<cell>(sums[k + 3], tables));
    __builtin_memcpy(out + cell * CellTables::kDirections + k, &four, sizeof four);
  }
}

/// The square root of the sum of squares.
inline float lengthOf(const float* v) {
  FloatV parts[kParts] = {};
  for (int i = 0; i < CellTables::kLength; i += kLanes) {
    for (int part = 0; part < kParts; ++part) {
      const FloatV value = load(v + i + part * kWidth);
      parts[part] += value * value;
    }
  }
  return __builtin_sqrtf(sumOfLanes(parts));
}

inline bool describeKernel(const Patch& patch, const CellTables& tables, float* descriptor) {
  constexpr int kCells = CellTables::kCells, kDirections = CellTables::kDirections;
  const float range = contrast(patch);
  if (!(range > 0)) return false;
  // A gradient is at most sqrt(2) times as long as the contrast, and lengths are below 2^15. The shares of
  // the rows of a cell add up to kCellSamples, so sums of lengths times 8192 are below 2^31.
  const float unit = 23160.0F / range;
  alignas(64) std::int32_t sums[kCells][kDirections][Patch::kPitch];
  GradientBand band;
  for (int number = 0; number <= kCells; ++number) {
    band.fill(patch, tables, number, unit);
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      IntV t[GradientBand::kPairs], a[GradientBand::kPairs], b[GradientBand::kPairs];
      for (int pair = 0; pair < GradientBand::kPairs; ++pair) {
        t[pair] = load(band.direction[pair] + c);
        a[pair] = load(band.before[pair] + c);
        b[pair] = load(band.after[pair] + c);
      }
      for (int k = 0; k < kDirections; ++k) {
        const HalfV centre = splatHalf(8192 * k);
        IntV before = splat(0), after = splat(0);
        for (int pair = 0; pair < GradientBand::kPairs; ++pair) {
          const IntV share = (IntV)tent((HalfV)t[pair], centre, splatHalf(8192));
          before = addProducts(before, share, a[pair]);
          after = addProducts(after, share, b[pair]);
        }
        if (number > 0) store(sums[number - 1][k] + c, load(sums[number - 1][k] + c) + before);
        if (number < kCells) store(sums[number][k] + c, after);
      }
    }
  }
  alignas(64) float values[CellTables::kLength];
  for (int row = 0; row < kCells; ++row) {
    float* const out = values + row * kCells * kDirections;
    poolColumns<0>(sums[row], tables, out);
    poolColumns<1>(sums[row], tables, out);
    poolColumns<2>(sums[row], tables, out);
    poolColumns<3>(sums[row], tables, out);
  }
  const float length = lengthOf(values);
  if (!(length > 0)) return false;
  const FloatV limit = splat(0.2F * length);
  for (int i = 0; i < CellTables::kLength; i += kWidth) store(values + i, minimum(load(values + i), limit));
  const FloatV factor = splat(512 / lengthOf(values));
  for (int i = 0; i < CellTables::kLength; i += kWidth) {
    const FloatV whole = toFloat(truncate(load(values + i) * factor + 0.5F));
    store(descriptor + i, minimum(whole, splat(255.0F)));
  }
  return true;
}

}  // namespace
}  // namespace corrsel::core
