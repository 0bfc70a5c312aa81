#pragma once

// The sums of vector field consensus, in double precision. Points come in whole groups of kFieldGroup, the
// last one filled up by the caller; group lane k of every group adds up into lane k of a sum, and lanes are
// added in a fixed order, so that all levels round alike.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kGroup = kFieldGroup;
constexpr std::size_t kGroupParts = kGroup / static_cast<std::size_t>(kDoubleWidth);

inline double totalOf(const double* lane) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/// The lanes of one sum.
struct LaneSum {
  DoubleV part[kGroupParts] = {};

  void add(std::size_t k, DoubleV v) { part[k] += v; }
  double total() const {
    double lane[kGroup];
    for (std::size_t k = 0; k < kGroupParts; ++k) store(lane + k * kDoubleWidth, part[k]);
    return totalOf(lane);
  }
};

/// The largest of positive numbers, 0 if there are none; it does not depend on the order.
struct LaneMaximum {
  DoubleV largest = {};

  void take(DoubleV v) { largest = v > largest ? v : largest; }
  double total() const {
    double result = 0;
    for (int k = 0; k < kDoubleWidth; ++k) result = largest[k] > result ? largest[k] : result;
    return result;
  }
};

/// e^x for x <= 0, relative error below 1e-15; e^-700 below that.
inline DoubleV exponential(DoubleV x) {
  constexpr double kLog2E = 1.4426950408889634, kLn2High = 0x1.62e42fee00000p-1,
                   kLn2Low = 1.90821492927058770e-10;
  constexpr double kRound = 0x1.8p52;  // adding it leaves the nearest whole number in the lowest bits
  x = x > -700.0 ? x : x * 0.0 - 700.0;
  const DoubleV rounded = x * kLog2E + kRound;
  const DoubleV n = rounded - kRound;
  const DoubleV r = (x - n * kLn2High) - n * kLn2Low;
  // Taylor's series: |r| <= ln(2) / 2 makes the first term left out 2e-16.
  DoubleV sum = r * (1.0 / 479001600.0) + 1.0 / 39916800.0;
  sum = sum * r + 1.0 / 3628800.0;
  sum = sum * r + 1.0 / 362880.0;
  sum = sum * r + 1.0 / 40320.0;
  sum = sum * r + 1.0 / 5040.0;
  sum = sum * r + 1.0 / 720.0;
  sum = sum * r + 1.0 / 120.0;
  sum = sum * r + 1.0 / 24.0;
  sum = sum * r + 1.0 / 6.0;
  sum = sum * r + 0.5;
  sum = sum * r + 1.0;
  sum = sum * r + 1.0;
  const LongV exponent = (LongV)rounded << 52;  // the bits above the whole number are shifted out
  return (DoubleV)((LongV)sum + exponent);
}

/// acc[r][c] += sum over `groups` groups of left[r] * right[c], lane by lane.
template <int kRows, int kColumns>
inline void addProducts(const double* left, std::size_t left_stride, const double* right,
                        std::size_t right_stride, std::size_t groups, double* acc, std::size_t acc_stride) {
  for (std::size_t part = 0; part < kGroupParts; ++part) {
    DoubleV sum[kRows][kColumns] = {};
    for (std::size_t g = 0; g < groups; ++g) {
      const std::size_t i = g * kGroup + part * kDoubleWidth;
      DoubleV l[kRows];
      for (int r = 0; r < kRows; ++r) l[r] = load(left + static_cast<std::size_t>(r) * left_stride + i);
      for (int c = 0; c < kColumns; ++c) {
        const DoubleV value = load(right + static_cast<std::size_t>(c) * right_stride + i);
        for (int r = 0; r < kRows; ++r) sum[r][c] += l[r] * value;
      }
    }
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kColumns; ++c) {
        double* const p = acc + static_cast<std::size_t>(r) * acc_stride +
                          static_cast<std::size_t>(c) * kGroup + part * kDoubleWidth;
        store(p, load(p) + sum[r][c]);
      }
    }
  }
}

// Products of two rows with as many columns as leave their sums in registers.
#if defined(__AVX512F__)
constexpr std::size_t kTileColumns = 8;
#else
constexpr std::size_t kTileColumns = 5;
#endif

/// The same for two rows and any number of columns, in tiles of nearly equal width.
inline void addRowPair(const double* left, std::size_t left_stride, const double* right,
                       std::size_t right_stride, std::size_t columns, std::size_t groups, double* acc,
                       std::size_t acc_stride) {
  for (std::size_t tiles = (columns + kTileColumns - 1) / kTileColumns; tiles > 0; --tiles) {
    const std::size_t width = columns / tiles;
#define CORRSEL_TILE(n)                                                                 \
  case n:                                                                               \
    addProducts<2, n>(left, left_stride, right, right_stride, groups, acc, acc_stride); \
    break
    switch (width) {
      CORRSEL_TILE(1);
      CORRSEL_TILE(2);
      CORRSEL_TILE(3);
      CORRSEL_TILE(4);
      CORRSEL_TILE(5);
#if defined(__AVX512F__)
      CORRSEL_TILE(6);
      CORRSEL_TILE(7);
      CORRSEL_TILE(8);
#endif
      default:
        break;
    }
#undef CORRSEL_TILE
    columns -= width;
    right += width * right_stride;
    acc += width * kGroup;
  }
}

constexpr std::size_t kChunk = 128;  // points whose products are added up while they are in the first cache

constexpr std::size_t kStrip = 4;  // groups that are worked on at a time, so that their operations overlap

/// Vectors of kGroups groups, from point i.
template <std::size_t kGroups>
struct Strip {
  static constexpr std::size_t kVectors = kGroups * kGroupParts;
  DoubleV v[kVectors];

  static constexpr std::size_t at(std::size_t i, std::size_t k) { return i + k * kDoubleWidth; }
  void read(const double* p, std::size_t i) {
    for (std::size_t k = 0; k < kVectors; ++k) v[k] = load(p + at(i, k));
  }
  void subtract(const double* p, std::size_t i, double factor) {
    for (std::size_t k = 0; k < kVectors; ++k) {
      __builtin_prefetch(p + at(i, k) + kChunk);
      v[k] -= load(p + at(i, k)) * factor;
    }
  }
};

template <std::size_t kGroups>
inline void factorStrip(const double* x, const double* y, double beta, const FieldPivots& pivots,
                        const FieldFactor& factor, std::size_t i, double* added, double* rest,
                        LaneMaximum& largest) {
  Strip<kGroups> px, py, left_over;
  px.read(x, i);
  py.read(y, i);
  left_over.read(rest, i);
  for (std::size_t c = 0; c < pivots.count; ++c) {
    Strip<kGroups> value;
    for (std::size_t k = 0; k < value.kVectors; ++k) {
      const DoubleV dx = px.v[k] - pivots.x[c], dy = py.v[k] - pivots.y[c];
      value.v[k] = exponential((dx * dx + dy * dy) * -beta);
    }
    const double* const row = pivots.rows + c * pivots.row_stride;
    for (std::size_t j = 0; j < factor.rank; ++j)
      value.subtract(factor.columns + (j + 2) * factor.stride, i, row[j]);
    for (std::size_t j = 0; j < c; ++j) value.subtract(added + j * factor.stride, i, row[factor.rank + j]);
    const double scale = 1.0 / __builtin_sqrt(pivots.rest[c]);
    for (std::size_t k = 0; k < value.kVectors; ++k) {
      const DoubleV entry = value.v[k] * scale;
      left_over.v[k] -= entry * entry;
      store(added + c * factor.stride + value.at(i, k), entry);
    }
  }
  for (std::size_t k = 0; k < left_over.kVectors; ++k) {
    store(rest + left_over.at(i, k), left_over.v[k]);
    largest.take(left_over.v[k]);
  }
}

double factorKernel(const double* x, const double* y, double beta, const FieldPivots& pivots,
                    const FieldFactor& factor, double* added, double* rest) {
  LaneMaximum largest;
  std::size_t i = 0;
  for (; i + kStrip * kGroup <= factor.padded; i += kStrip * kGroup)
    factorStrip<kStrip>(x, y, beta, pivots, factor, i, added, rest, largest);
  for (; i < factor.padded; i += kGroup) factorStrip<1>(x, y, beta, pivots, factor, i, added, rest, largest);
  return largest.total();
}

void gramKernel(const FieldFactor& factor, const double* weight, double* lanes, double* gram) {
  const std::size_t columns = factor.rank + 2;
  for (std::size_t k = 0; k < columns * columns * kGroup; ++k) lanes[k] = 0;
  alignas(64) double rows[2 * kChunk];
  for (std::size_t begin = 0; begin < factor.padded; begin += kChunk) {
    const std::size_t count = begin + kChunk < factor.padded ? kChunk : factor.padded - begin;
    for (std::size_t j = 0; j < columns; j += 2) {
      const bool pair = j + 1 < columns;  // else the second row is zero and adds nothing
      const double* const a = factor.columns + j * factor.stride + begin;
      const double* const b = pair ? a + factor.stride : a;
      for (std::size_t i = 0; i < count; i += kDoubleWidth) {
        const DoubleV w = load(weight + begin + i);
        __builtin_prefetch(a + kChunk + i);
        __builtin_prefetch(b + kChunk + i);
        store(rows + i, w * load(a + i));
        store(rows + kChunk + i, pair ? w * load(b + i) : DoubleV{});
      }
      addRowPair(rows, kChunk, a, factor.stride, columns - j, count / kGroup,
                 lanes + (j * columns + j) * kGroup, pair ? columns * kGroup : 0);
    }
  }
  for (std::size_t k = 0; k < columns * columns; ++k) gram[k] = totalOf(lanes + k * kGroup);
}

template <std::size_t kGroups>
inline void residualStrip(const FieldFactor& factor, const double* coefficients, const double* weight,
                          std::size_t i, double* squared, LaneSum& sum) {
  Strip<kGroups> ru, rv;
  ru.read(factor.columns, i);
  rv.read(factor.columns + factor.stride, i);
  for (std::size_t j = 0; j < factor.rank; ++j) {
    const double* const column = factor.columns + (j + 2) * factor.stride;
    ru.subtract(column, i, coefficients[2 * j]);
    rv.subtract(column, i, coefficients[2 * j + 1]);
  }
  for (std::size_t k = 0; k < ru.kVectors; ++k) {
    const DoubleV r = ru.v[k] * ru.v[k] + rv.v[k] * rv.v[k];
    store(squared + ru.at(i, k), r);
    sum.add(k % kGroupParts, r * load(weight + ru.at(i, k)));
  }
}

double fieldResidualsKernel(const FieldFactor& factor, const double* coefficients, const double* weight,
                            double* squared) {
  LaneSum sum;
  std::size_t i = 0;
  for (; i + kStrip * kGroup <= factor.padded; i += kStrip * kGroup)
    residualStrip<kStrip>(factor, coefficients, weight, i, squared, sum);
  for (; i < factor.padded; i += kGroup) residualStrip<1>(factor, coefficients, weight, i, squared, sum);
  return sum.total();
}

FieldPosteriorSums posteriorsKernel(const FieldPosteriorRule& rule, const double* squared, std::size_t size,
                                    double* posterior) {
  LaneSum weighted, sum, clamped, accepted;
  double number[kGroup];
  for (std::size_t k = 0; k < kGroup; ++k) number[k] = static_cast<double>(k);
  for (std::size_t i = 0; i < size; i += kGroup) {
    const double left = static_cast<double>(size - i);
    for (std::size_t part = 0; part < kGroupParts; ++part) {
      const std::size_t at = i + part * kDoubleWidth;
      const DoubleV r = load(squared + at);
      const DoubleV e = exponential(r * rule.exponent);
      const LongV valid = load(number + part * kDoubleWidth) < left;
      const DoubleV zero{};
      const DoubleV p = valid ? e / (e + rule.outlier) : zero;
      const DoubleV kept = p > rule.min_posterior ? p : rule.min_posterior - zero;
      const DoubleV weight = valid ? kept : zero;
      weighted.add(part, p * r);
      sum.add(part, p);
      clamped.add(part, weight);
      accepted.add(part, p > rule.threshold ? zero + 1.0 : zero);
      store(posterior + at, weight);
    }
  }
  return {weighted.total(), sum.total(), clamped.total(), accepted.total()};
}

}  // namespace
}  // namespace corrsel::core
