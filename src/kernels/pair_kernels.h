#pragma once

// Values of pairs of matches, and products with the symmetric matrix that they form.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

typedef std::uint16_t FixedV __attribute__((vector_size(kWidth * 2)));

inline FloatV loadFixed(const std::uint16_t* p) {
#if defined(__AVX2__) && !defined(__AVX512F__)
  // GCC 12 splits the conversion below.
  return toFloat((IntV)_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
#else
  FixedV v;
  __builtin_memcpy(&v, p, sizeof v);
  return toFloat(__builtin_convertvector(v, IntV));
#endif
}

/// Values in [0, 1] to the nearest multiple of 1 / kOne.
inline void storeFixed(std::uint16_t* p, FloatV value) {
  const IntV v = truncate(value * PairBlock::kOne + 0.5F);
#if defined(__AVX2__) && !defined(__AVX512F__)
  const __m128i low = _mm256_castsi256_si128((__m256i)v), high = _mm256_extracti128_si256((__m256i)v, 1);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm_packus_epi32(low, high));
#else
  const FixedV fixed = __builtin_convertvector(v, FixedV);
  __builtin_memcpy(p, &fixed, sizeof fixed);
#endif
}

inline FloatV where(IntV mask, FloatV v) { return mask ? v : FloatV{}; }

/// One match on every lane.
struct Match {
  FloatV x, y, u, v;          // left and right position
  FloatV a11, a12, a21, a22;  // from the left frame to the right one
};

template <bool kWithFrames>
inline Match matchAt(const PairColumns& m, std::size_t j) {
  Match result = {
      load(m.left_x + j), load(m.left_y + j), load(m.right_x + j), load(m.right_y + j), {}, {}, {}, {}};
  if (kWithFrames) {
    result.a11 = load(m.a11 + j);
    result.a12 = load(m.a12 + j);
    result.a21 = load(m.a21 + j);
    result.a22 = load(m.a22 + j);
  }
  return result;
}

template <bool kWithFrames>
inline Match splatMatch(const PairColumns& m, std::size_t i) {
  Match result = {
      splat(m.left_x[i]), splat(m.left_y[i]), splat(m.right_x[i]), splat(m.right_y[i]), {}, {}, {}, {}};
  if (kWithFrames) {
    result.a11 = splat(m.a11[i]);
    result.a12 = splat(m.a12[i]);
    result.a21 = splat(m.a21[i]);
    result.a22 = splat(m.a22[i]);
  }
  return result;
}

/// Squared distances of two matches in both images.
struct SquaredDistances {
  FloatV left, right;
  SquaredDistances(const Match& i, const Match& j) {
    const FloatV dx = j.x - i.x, dy = j.y - i.y, du = j.u - i.u, dv = j.v - i.v;
    left = dx * dx + dy * dy;
    right = du * du + dv * dv;
  }
  FloatV smaller() const { return minimum(left, right); }
  FloatV larger() const { return maximum(left, right); }
  FloatV difference() const { return absolute(squareRoot(left) - squareRoot(right)); }
  /// Where exactly one of the two points is shared.
  IntV shareOnePoint() const { return (smaller() == 0.0F) & (larger() > 0.0F); }
};

struct RatioOfDistances {
  static constexpr bool kFrames = false;
  static FloatV value(const PairRule&, const Match& i, const Match& j) {
    const SquaredDistances d(i, j);
    // Matches at one place have no ratio; no column holds a match twice.
    return where(d.larger() > 0.0F, squareRoot(d.smaller() / d.larger()));
  }
  static IntV conflict(const PairRule& rule, const Match& i, const Match& j) {
    const SquaredDistances d(i, j);
    IntV conflict = d.smaller() <= rule.squared_threshold * d.larger();
    if (rule.noise_floor > 0) conflict &= d.difference() > rule.noise_floor;
    return rule.one_to_one ? conflict | d.shareOnePoint() : conflict;
  }
};

struct DifferenceOfDistances {
  static constexpr bool kFrames = false;
  static FloatV value(const PairRule& rule, const Match& i, const Match& j) {
    const SquaredDistances d(i, j);
    const FloatV difference = d.difference();
    const FloatV value = maximum(1.0F - difference * difference * rule.scale, FloatV{});
    return rule.one_to_one ? where(~d.shareOnePoint(), value) : value;
  }
  static IntV conflict(const PairRule& rule, const Match& i, const Match& j) {
    const SquaredDistances d(i, j);
    const FloatV difference = d.difference();
    const FloatV value = maximum(1.0F - difference * difference * rule.scale, FloatV{});
    const IntV conflict = (value <= rule.threshold) & (difference > rule.noise_floor);
    return rule.one_to_one ? conflict | d.shareOnePoint() : conflict;
  }
};

/// 2^x. Relative error below 3e-7; 1 for 0 and 0 for x <= -126. @pre x <= 0
inline FloatV exponential2(FloatV x) {
  const FloatV bounded = maximum(x, splat(-126.0F));
  const IntV whole = truncate(bounded - 0.5F);  // nearest, as x is not positive
  const FloatV f = bounded - toFloat(whole);
  // (2^f - 1) / f interpolated at the Chebyshev nodes of |f| <= 1/2.
  FloatV p = f * 1.33813021e-3F + 9.66636837e-3F;
  p = p * f + 0.0555038117F;
  p = p * f + 0.240223497F;
  p = p * f + 0.693147182F;
  p = p * f + 1.0F;
  return where(x > -126.0F, p * (FloatV)((whole + 127) << 23));
}

struct Payoff {
  static constexpr bool kFrames = true;
  static FloatV value(const PairRule& rule, const Match& i, const Match& j) {
    const FloatV dx = j.x - i.x, dy = j.y - i.y, du = j.u - i.u, dv = j.v - i.v;
    // |x'_j - T_i(x_j)| and |x'_i - T_j(x_i)|: each match predicts where the other one ends.
    const FloatV by_i = absolute(du - (i.a11 * dx + i.a12 * dy)) + absolute(dv - (i.a21 * dx + i.a22 * dy));
    const FloatV by_j = absolute(du - (j.a11 * dx + j.a12 * dy)) + absolute(dv - (j.a21 * dx + j.a22 * dy));
    const FloatV value = exponential2(-rule.scale * maximum(by_i, by_j));
    if (!rule.one_to_one) return value;
    const IntV same_left = (dx == 0.0F) & (dy == 0.0F), same_right = (du == 0.0F) & (dv == 0.0F);
    return where(~(same_left | same_right), value);
  }
};

template <class P>
void pairBlockKernel(const PairColumns& m, const PairRule& rule, std::size_t row, std::size_t begin,
                     std::size_t end, std::uint16_t* out) {
  Match rows[PairBlock::kRows];
  for (std::size_t r = 0; r < PairBlock::kRows; ++r) rows[r] = splatMatch<P::kFrames>(m, row + r);
  for (std::size_t j = begin; j < end; j += PairBlock::kColumns) {
    for (std::size_t part = 0; part < PairBlock::kColumns; part += kWidth) {
      const Match other = matchAt<P::kFrames>(m, j + part);
#pragma GCC unroll 4
      for (std::size_t r = 0; r < PairBlock::kRows; ++r)
        storeFixed(out + r * PairBlock::kColumns + part, P::value(rule, rows[r], other));
    }
    out += PairBlock::kRows * PairBlock::kColumns;
  }
}

template <class P>
void pairRowKernel(const PairColumns& m, const PairRule& rule, std::size_t row, std::size_t end, float* out) {
  const Match match = splatMatch<P::kFrames>(m, row);
  for (std::size_t j = 0; j < end; j += kWidth)
    store(out + j, P::value(rule, match, matchAt<P::kFrames>(m, j)));
}

template <class P>
void pairConflictsKernel(const PairColumns& m, const PairRule& rule, std::size_t row, std::size_t begin,
                         std::size_t end, std::int32_t* alive) {
  const Match match = splatMatch<P::kFrames>(m, row);
  for (std::size_t j = begin; j < end; j += kWidth) {
    IntV v;
    __builtin_memcpy(&v, alive + j, sizeof v);
    v &= ~P::conflict(rule, match, matchAt<P::kFrames>(m, j));
    __builtin_memcpy(alive + j, &v, sizeof v);
  }
}

void pairProductKernel(const std::uint16_t* block, std::size_t columns, const float* v_rows, const float* v,
                       float* y, double* y_rows) {
  static_assert(PairBlock::kColumns == kLanes, "one lane per column");
  FloatV sums[PairBlock::kRows][kParts] = {};
  FloatV factors[PairBlock::kRows];
  for (std::size_t r = 0; r < PairBlock::kRows; ++r) factors[r] = splat(v_rows[r]);
  for (std::size_t j = 0; j < columns; j += PairBlock::kColumns) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::size_t lane = part * kWidth;
      const FloatV vj = load(v + j + lane);
      FloatV yj = load(y + j + lane);
#pragma GCC unroll 4
      for (std::size_t r = 0; r < PairBlock::kRows; ++r) {
        const FloatV a = loadFixed(block + r * PairBlock::kColumns + lane);
        sums[r][part] += a * vj;
        yj += a * factors[r];
      }
      store(y + j + lane, yj);
    }
    block += PairBlock::kRows * PairBlock::kColumns;
  }
  for (std::size_t r = 0; r < PairBlock::kRows; ++r) {
    double sum = 0;
    for (std::size_t part = 0; part < kParts; ++part) {
      for (int k = 0; k < kWidth; ++k) sum += static_cast<double>(sums[r][part][k]);
    }
    y_rows[r] += sum;
  }
}

}  // namespace
}  // namespace corrsel::core
