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

/// Replaces n vectors of x <= 0 by e^x, with a relative error below 1e-15, and by e^-700 for smaller x. The
/// vectors take each step together, because the steps of one wait for each other.
template <std::size_t n>
inline void exponentials(DoubleV* x) {
  constexpr double kLog2E = 1.4426950408889634, kLn2High = 0x1.62e42fee00000p-1,
                   kLn2Low = 1.90821492927058770e-10;
  constexpr double kRound = 0x1.8p52;  // adding it leaves the nearest whole number in the lowest bits
  // Taylor's series: |r| <= ln(2) / 2 makes the first term left out 2e-16.
  constexpr double kEven[] = {1.0 / 3628800.0, 1.0 / 40320.0, 1.0 / 720.0, 1.0 / 24.0, 0.5};
  constexpr double kOdd[] = {1.0 / 362880.0, 1.0 / 5040.0, 1.0 / 120.0, 1.0 / 6.0, 1.0};
  LongV exponent[n];
  DoubleV r[n], squared[n], even[n], odd[n];
  for (std::size_t k = 0; k < n; ++k) {
    const DoubleV bounded = x[k] > -700.0 ? x[k] : x[k] * 0.0 - 700.0;
    const DoubleV rounded = bounded * kLog2E + kRound;
    const DoubleV whole = rounded - kRound;
    exponent[k] = (LongV)rounded << 52;  // the bits above the whole number are shifted out
    r[k] = (bounded - whole * kLn2High) - whole * kLn2Low;
  }
  for (std::size_t k = 0; k < n; ++k) {
    squared[k] = r[k] * r[k];
    even[k] = squared[k] * (1.0 / 479001600.0) + kEven[0];
    odd[k] = squared[k] * (1.0 / 39916800.0) + kOdd[0];
  }
  for (int term = 1; term < 5; ++term) {
    for (std::size_t k = 0; k < n; ++k) {
      even[k] = even[k] * squared[k] + kEven[term];
      odd[k] = odd[k] * squared[k] + kOdd[term];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    const DoubleV sum = odd[k] * r[k] + even[k] * squared[k] + 1.0;
    x[k] = (DoubleV)((LongV)sum + exponent[k]);
  }
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

// Rows and columns of the largest tile of products whose sums stay in registers.
#if defined(__AVX512F__)
constexpr int kTileRows = 2, kTileColumns = 8;
#else
constexpr int kTileRows = 4, kTileColumns = 3;
#endif

/// addProducts for `rows` of at most kRows rows and `columns` of at most kColumns columns.
template <int kRows, int kColumns>
inline void addTile(std::size_t rows, std::size_t columns, const double* left, std::size_t left_stride,
                    const double* right, std::size_t right_stride, std::size_t groups, double* acc,
                    std::size_t acc_stride) {
  if constexpr (kRows > 1) {
    if (rows < kRows) {
      return addTile<kRows - 1, kColumns>(rows, columns, left, left_stride, right, right_stride, groups, acc,
                                          acc_stride);
    }
  }
  if constexpr (kColumns > 1) {
    if (columns < kColumns) {
      return addTile<kRows, kColumns - 1>(rows, columns, left, left_stride, right, right_stride, groups, acc,
                                          acc_stride);
    }
  }
  addProducts<kRows, kColumns>(left, left_stride, right, right_stride, groups, acc, acc_stride);
}

constexpr std::size_t kChunk = 128;  // points whose products are added up while they are in the first cache

// Groups that are worked on at a time, so that their operations overlap.
constexpr std::size_t kFactorStrip = 4, kResidualStrip = 4 / kGroupParts;

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
      if (k % kGroupParts == 0) __builtin_prefetch(p + at(i, k) + kChunk);
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
    constexpr std::size_t kTogether = value.kVectors < 4 ? value.kVectors : 4;
    for (std::size_t first = 0; first < value.kVectors; first += kTogether) {
      for (std::size_t k = first; k < first + kTogether; ++k) {
        const DoubleV dx = px.v[k] - pivots.x[c], dy = py.v[k] - pivots.y[c];
        value.v[k] = (dx * dx + dy * dy) * -beta;
      }
      exponentials<kTogether>(value.v + first);
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
  for (; i + kFactorStrip * kGroup <= factor.padded; i += kFactorStrip * kGroup)
    factorStrip<kFactorStrip>(x, y, beta, pivots, factor, i, added, rest, largest);
  for (; i < factor.padded; i += kGroup) factorStrip<1>(x, y, beta, pivots, factor, i, added, rest, largest);
  return largest.total();
}

void gramKernel(const FieldFactor& factor, const double* weight, double* lanes, double* gram) {
  const std::size_t columns = factor.rank + 2;
  for (std::size_t k = 0; k < columns * columns * kGroup; ++k) lanes[k] = 0;
  alignas(64) double weighted[kTileRows * kChunk];
  for (std::size_t begin = 0; begin < factor.padded; begin += kChunk) {
    const std::size_t count = begin + kChunk < factor.padded ? kChunk : factor.padded - begin;
    for (std::size_t j = 0, rows; j < columns; j += rows) {
      rows = columns - j < kTileRows ? columns - j : kTileRows;
      const double* const first = factor.columns + j * factor.stride + begin;
      for (std::size_t r = 0; r < rows; ++r) {
        const double* const row = first + r * factor.stride;
        for (std::size_t i = 0; i < count; i += kGroup) {
          __builtin_prefetch(row + kChunk + i);
          for (std::size_t k = i; k < i + kGroup; k += kDoubleWidth)
            store(weighted + r * kChunk + k, load(weight + begin + k) * load(row + k));
        }
      }
      // Tiles of nearly equal width.
      std::size_t k = j;
      for (std::size_t tiles = (columns - j + kTileColumns - 1) / kTileColumns; tiles > 0; --tiles) {
        const std::size_t width = (columns - k) / tiles;
        addTile<kTileRows, kTileColumns>(
            rows, width, weighted, kChunk, factor.columns + k * factor.stride + begin, factor.stride,
            count / kGroup, lanes + (j * columns + k) * kGroup, columns * kGroup);
        k += width;
      }
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
  for (; i + kResidualStrip * kGroup <= factor.padded; i += kResidualStrip * kGroup)
    residualStrip<kResidualStrip>(factor, coefficients, weight, i, squared, sum);
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
    DoubleV e[kGroupParts];
    for (std::size_t part = 0; part < kGroupParts; ++part)
      e[part] = load(squared + i + part * kDoubleWidth) * rule.exponent;
    exponentials<kGroupParts>(e);
    for (std::size_t part = 0; part < kGroupParts; ++part) {
      const std::size_t at = i + part * kDoubleWidth;
      const DoubleV r = load(squared + at);
      const LongV valid = load(number + part * kDoubleWidth) < left;
      const DoubleV zero{};
      const DoubleV p = valid ? e[part] / (e[part] + rule.outlier) : zero;
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
