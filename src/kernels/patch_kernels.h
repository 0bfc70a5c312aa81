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
#elif defined(__AVX2__)
  return (IntV)_mm256_i32gather_epi32(reinterpret_cast<const int*>(pixels), (__m256i)offset, 2);
#else
  IntV v;
  for (int k = 0; k < kWidth; ++k) {
    std::int32_t pair;
    __builtin_memcpy(&pair, pixels + offset[k], sizeof pair);
    v[k] = pair;
  }
  return v;
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
  constexpr int kReach = PatchKernels::kMostReach;
  alignas(64) float padded[kReach + Patch::kPitch + kReach];
  for (int r = 0; r < Patch::kSide; ++r) {
    float* const row = patch.values + r * Patch::kPitch;
    for (int k = 0; k < kReach; ++k) {
      padded[k] = row[0];
      padded[kReach + Patch::kPitch + k] = row[Patch::kSide - 1];
    }
    for (int c = 0; c < Patch::kPitch; c += kWidth) store(padded + kReach + c, load(row + c));
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      const float* const middle = padded + kReach + c;
      FloatV sum = half[0] * load(middle);
      for (int k = 1; k <= reach; ++k) sum += half[k] * (load(middle - k) + load(middle + k));
      store(row + c, sum);
    }
    row[Patch::kSide] = row[Patch::kSide - 1];
  }
}

inline void blurColumnsKernel(const float* half, int reach, Patch& patch) {
  constexpr int kReach = PatchKernels::kMostReach, kRows = Patch::kSide + 2 * kReach;
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

inline void directionsKernel(const Patch& patch, const PatchWeights& window, DirectionCounts& counts) {
  constexpr int kBins = DirectionCounts::kBins, kShareBits = 8, kShares = 1 << kShareBits;
  // Every entry has the sum for its bin in the lower half and that for the next bin in the upper half. Two
  // histograms are filled in turn, so that additions to the same bin wait less often.
  std::uint64_t sums[2][kBins + 1] = {};
  const float range = contrast(patch);
  // A gradient is at most sqrt(2) times as long as the contrast.
  const float unit = range > 0 ? 11585.0F / range : 0.0F;
  for (int r = 0; r < Patch::kInner; ++r) {
    alignas(64) std::int32_t position[Patch::kPitch], length[Patch::kPitch];
    for (int c = 0; c < Patch::kPitch; c += kWidth) {
      const GradientV g(patch, r, c);
      const FloatV weight = unit * load(window.values + r * Patch::kPitch + c);
      store(position + c, truncate(g.direction() * (kBins * kShares) + 0.5F));
      store(length + c, truncate(g.length() * weight + 0.5F));
    }
    for (int c = 0; c < Patch::kInner; ++c) {
      const auto share = static_cast<std::uint64_t>(position[c] & (kShares - 1));
      const auto weight = static_cast<std::uint64_t>(length[c]);
      sums[c & 1][position[c] >> kShareBits] += weight * ((share << 32) + kShares - share);
    }
  }
  for (int k = 0; k <= kBins; ++k) sums[0][k] += sums[1][k];
  sums[0][0] += sums[0][kBins];
  for (int k = 0; k < kBins; ++k) {
    const std::uint64_t before = sums[0][k == 0 ? kBins - 1 : k - 1];
    counts.bins[k] = static_cast<float>((sums[0][k] & 0xffffffffU) + (before >> 32));
  }
}

/// 8192 - |t - centre| per 16-bit lane, where t and centre are on a circle of 2^16, or 0 where this is
/// negative.
inline HalfV tent(HalfV t, HalfV centre) {
  const HalfV d = t - centre;
#if defined(__AVX512F__)
  return (HalfV)_mm512_subs_epu16(_mm512_set1_epi16(8192), _mm512_abs_epi16((__m512i)d));
#elif defined(__AVX2__)
  return (HalfV)_mm256_subs_epu16(_mm256_set1_epi16(8192), _mm256_abs_epi16((__m256i)d));
#elif defined(__SSE2__)
  const __m128i distance = _mm_max_epi16((__m128i)d, _mm_sub_epi16(_mm_setzero_si128(), (__m128i)d));
  return (HalfV)_mm_subs_epu16(_mm_set1_epi16(8192), distance);
#else
  const HalfV other = -d, distance = d < other ? d : other;
  return distance < 8192 ? 8192 - distance : HalfV{};
#endif
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
          t[side] = truncate(g.direction() * 65536.0F + 0.5F);
          a[side] = truncate(length * load(tables.rows[row][0] + c) + 0.5F);
          b[side] = truncate(length * load(tables.rows[row][1] + c) + 0.5F);
        }
        store(direction[pair] + c, (t[0] & 0xffff) | (t[1] << 16));
        store(before[pair] + c, a[0] | (a[1] << 16));
        store(after[pair] + c, b[0] | (b[1] << 16));
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
        const HalfV centre = static_cast<std::uint16_t>(8192 * k) - HalfV{};
        IntV before = splat(0), after = splat(0);
        for (int pair = 0; pair < GradientBand::kPairs; ++pair) {
          const IntV share = (IntV)tent((HalfV)t[pair], centre);
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
