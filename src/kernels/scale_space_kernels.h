#pragma once

#include "kernels/scale_space.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr int kWeightBits = 15;
constexpr std::int32_t kHalfWeight = 1 << (kWeightBits - 1);

/// Sums of 16-bit products for kBlocks vectors of pixels, in 32 bits and interleaved order.
template <int kBlocks>
struct ColumnSums {
  IntV low[kBlocks], high[kBlocks];

  ColumnSums() {
    for (int k = 0; k < kBlocks; ++k) low[k] = high[k] = splat(kHalfWeight);
  }

  void add(const ShortV* low_pixels, const ShortV* high_pixels, std::int32_t weights) {
    const IntV w = splat(weights);
    for (int k = 0; k < kBlocks; ++k) {
      low[k] = addProducts(low[k], (IntV)low_pixels[k], w);
      high[k] = addProducts(high[k], (IntV)high_pixels[k], w);
    }
  }

  void put(std::int16_t* out) const {
    for (int k = 0; k < kBlocks; ++k) {
      store(out + k * kShorts, narrow(low[k] >> kWeightBits, high[k] >> kWeightBits));
    }
  }
};

template <int kBlocks>
inline void filterColumnsAt(const std::int16_t* const* rows, const std::int32_t* first_weights,
                            const std::int32_t* second_weights, int pairs, int x, std::int16_t* first,
                            std::int16_t* second) {
  ColumnSums<kBlocks> one, two;
  for (int j = 0; j < pairs; ++j) {
    const std::int16_t *const upper = rows[2 * j] + x, *const lower = rows[2 * j + 1] + x;
    ShortV low[kBlocks], high[kBlocks];
    for (int k = 0; k < kBlocks; ++k) {
      const ShortV a = load(upper + k * kShorts), b = load(lower + k * kShorts);
      low[k] = interleaveLow(a, b);
      high[k] = interleaveHigh(a, b);
    }
    one.add(low, high, first_weights[j]);
    two.add(low, high, second_weights[j]);
  }
  one.put(first + x);
  two.put(second + x);
}

void filterColumnsKernel(const std::int16_t* const* rows, const std::int32_t* first_weights,
                         const std::int32_t* second_weights, int pairs, int n, std::int16_t* first,
                         std::int16_t* second) {
  constexpr int kBlocks = 2;
  int x = 0;
  for (; x + kBlocks * kShorts <= n; x += kBlocks * kShorts) {
    filterColumnsAt<kBlocks>(rows, first_weights, second_weights, pairs, x, first, second);
  }
  for (; x < n; x += kShorts) {
    filterColumnsAt<1>(rows, first_weights, second_weights, pairs, x, first, second);
  }
}

/// Sums of the products of pairs of neighbouring pixels, which begin at even and at odd positions.
template <int kBlocks>
struct RowSums {
  IntV even[kBlocks], odd[kBlocks];

  RowSums() {
    for (int k = 0; k < kBlocks; ++k) even[k] = odd[k] = splat(kHalfWeight);
  }

  void add(const ShortV* even_pixels, const ShortV* odd_pixels, std::int32_t weights) {
    const IntV w = splat(weights);
    for (int k = 0; k < kBlocks; ++k) {
      even[k] = addProducts(even[k], (IntV)even_pixels[k], w);
      odd[k] = addProducts(odd[k], (IntV)odd_pixels[k], w);
    }
  }
};

/// Two filtered values, of which `first` goes to the lower 16 bits.
inline IntV pairOf(IntV first, IntV second) {
  const IntV upper = splat(static_cast<std::int32_t>(~0xFFFFU));
  return (first >> kWeightBits) | ((second << (16 - kWeightBits)) & upper);
}

template <int kBlocks>
inline void filterRowAt(const std::int16_t* in, const std::int32_t* weights, int pairs, std::int16_t* out) {
  RowSums<kBlocks> sums;
  for (int j = 0; j < pairs; ++j) {
    ShortV even[kBlocks], odd[kBlocks];
    for (int k = 0; k < kBlocks; ++k) {
      even[k] = load(in + k * kShorts + 2 * j);
      odd[k] = load(in + k * kShorts + 2 * j + 1);
    }
    sums.add(even, odd, weights[j]);
  }
  for (int k = 0; k < kBlocks; ++k) store(out + k * kShorts, (ShortV)pairOf(sums.even[k], sums.odd[k]));
}

void filterRowKernel(const std::int16_t* in, const std::int32_t* weights, int pairs, int n,
                     std::int16_t* out) {
  constexpr int kBlocks = 4;
  int x = 0;
  for (; x + kBlocks * kShorts <= n; x += kBlocks * kShorts) {
    filterRowAt<kBlocks>(in + x, weights, pairs, out + x);
  }
  for (; x < n; x += kShorts) filterRowAt<1>(in + x, weights, pairs, out + x);
}

void doubleRowKernel(const std::int16_t* in, const std::int32_t* first_weights,
                     const std::int32_t* second_weights, int pairs, int n, std::int16_t* out) {
  constexpr int kChunk = 8;  // pixels of 128 bits, within which vectors are interleaved
  for (int x = 0; x < n; x += kShorts) {
    RowSums<1> one, two;
    for (int j = 0; j < pairs; ++j) {
      const ShortV even = load(in + x + 2 * j), odd = load(in + x + 2 * j + 1);
      one.add(&even, &odd, first_weights[j]);
      two.add(&even, &odd, second_weights[j]);
    }
    const IntV even = pairOf(one.even[0], two.even[0]), odd = pairOf(one.odd[0], two.odd[0]);
    std::int16_t low[kShorts], high[kShorts];
    store(low, (ShortV)interleaveLow(even, odd));
    store(high, (ShortV)interleaveHigh(even, odd));
    for (int k = 0; k < kShorts; k += kChunk) {
      __builtin_memcpy(out + 2 * x + 2 * k, low + k, sizeof(std::int16_t) * kChunk);
      __builtin_memcpy(out + 2 * x + 2 * k + kChunk, high + k, sizeof(std::int16_t) * kChunk);
    }
  }
}

void subtractRowsKernel(const std::int16_t* a, const std::int16_t* b, int n, std::int16_t* out) {
  for (int x = 0; x < n; x += kShorts) store(out + x, load(b + x) - load(a + x));
}

/// The largest and the smallest values of columns.
struct Range {
  ShortV high, low;

  explicit Range(ShortV v) : high(v), low(v) {}
  void add(const Range& other) {
    high = maximum(high, other.high);
    low = minimum(low, other.low);
  }
};

/// The range over the rows before, at and after a row of one level, from column x on.
inline Range rangeOfRows(const std::int16_t* const* three, int x) {
  Range range(load(three[0] + x));
  range.add(Range(load(three[1] + x)));
  range.add(Range(load(three[2] + x)));
  return range;
}

/// The ranges over three rows and three levels for kColumns pixels, which stay in the cache.
struct LevelRanges {
  static constexpr int kColumns = 256, kMaxLevels = ScaleSpaceKernels::kMaxLevels;
  alignas(64) std::int16_t high[kMaxLevels + 1][kColumns + 2 * kShorts],
      low[kMaxLevels + 1][kColumns + 2 * kShorts];

  /// Finds those of `columns` pixels from column x on, and of one more on each side.
  void find(const std::int16_t* const* rows, int levels, int x, int columns) {
    for (int c = 0; c < columns + 2; c += kShorts) {
      Range before = rangeOfRows(rows, x - 1 + c), at = rangeOfRows(rows + 3, x - 1 + c);
      for (int level = 1; level <= levels; ++level) {
        const Range after = rangeOfRows(rows + 3 * (level + 1), x - 1 + c);
        before.add(at);
        before.add(after);
        store(high[level] + c, before.high);
        store(low[level] + c, before.low);
        before = at;
        at = after;
      }
    }
  }

  /// Which values of pixels from the c-th on are the extremum of their neighbours and of +-limit.
  ShortV extremal(ShortV value, int level, int c, ShortV limit) const {
    const std::int16_t *const h = high[level] + c, *const l = low[level] + c;
    const ShortV largest = maximum(maximum(load(h), load(h + 1)), maximum(load(h + 2), limit));
    const ShortV smallest = minimum(minimum(load(l), load(l + 1)), minimum(load(l + 2), -limit));
    return (value == largest) | (value == smallest);
  }
};

/// Whether no neighbour before the place equals its value. @pre it is an extremum
inline bool isFirst(const std::int16_t* const* rows, int level, int column) {
  const std::int16_t value = rows[3 * level + 1][column];
  for (int k = 0; k < 13; ++k) {
    if (rows[3 * (level - 1) + k / 3][column + k % 3 - 1] == value) return false;
  }
  return true;
}

/// Writes the places of a level whose mask is set among n pixels from column x on. @return their number
inline int takePlaces(const std::int16_t* const* rows, int level, int x, const std::int16_t (&mask)[kShorts],
                      int n, std::int16_t threshold, ExtremumPlace* found) {
  constexpr int kFour = 4;  // lanes at a time that are skipped where there is nothing
  int count = 0;
  for (int first = 0; first < n; first += kFour) {
    std::uint64_t four = 0;
    __builtin_memcpy(&four, mask + first, sizeof four);
    if (four == 0) continue;
    for (int k = first; k < first + kFour && k < n; ++k) {
      const int v = rows[3 * level + 1][x + k];
      // A value that equals the limit is not beyond it.
      if (mask[k] != 0 && v != threshold && v != -threshold && isFirst(rows, level, x + k))
        found[count++] = {x + k, level};
    }
  }
  return count;
}

int extremaKernel(const std::int16_t* const* rows, int levels, int begin, int end, std::int16_t threshold,
                  ExtremumPlace* found) {
  LevelRanges ranges;
  std::int16_t masks[LevelRanges::kMaxLevels + 1][kShorts];
  int count = 0;
  for (int first = begin; first < end; first += LevelRanges::kColumns) {
    const int columns = end - first < LevelRanges::kColumns ? end - first : LevelRanges::kColumns;
    ranges.find(rows, levels, first, columns);
    const ShortV limit = splat(threshold);
    for (int c = 0; c < columns; c += kShorts) {
      ShortV any{};
      for (int level = 1; level <= levels; ++level) {
        const ShortV mask = ranges.extremal(load(rows[3 * level + 1] + first + c), level, c, limit);
        store(masks[level], mask);
        any |= mask;
      }
      if (!anyTrue(any)) continue;
      const int n = columns - c < kShorts ? columns - c : kShorts;
      for (int level = 1; level <= levels; ++level)
        count += takePlaces(rows, level, first + c, masks[level], n, threshold, found + count);
    }
  }
  return count;
}

}  // namespace
}  // namespace corrsel::core
