#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/largest_magnitude.h"

namespace corrsel::core {

/// Numbers that tell the places of points apart: a place is a square cell, and a key holds its column and
/// row.

/// Points whose keys are written at a time, so that the keys stay in registers or in the cache.
inline constexpr std::size_t kPlaceBlock = 64;

/// Writes the numbers of the cells of some coordinates, or, where such numbers would be too large, the bits
/// of the coordinates.
/// @param shift  0.5 rounds to the nearest multiple of the cell, 0 rounds down
template <bool exact>
void cellsOf(const float* values, std::size_t count, float inverse_cell, float shift, std::int32_t* cells) {
  for (std::size_t k = 0; k < count; ++k) {
    if constexpr (exact) {
      const float positive_zero = values[k] + 0.0F;
      std::memcpy(&cells[k], &positive_zero, sizeof cells[k]);
    } else {
      // std::floor() would be a call without SSE4.1.
      const float shifted = values[k] * inverse_cell + shift;
      const auto truncated = static_cast<std::int32_t>(shifted);
      cells[k] = truncated - (static_cast<float>(truncated) > shifted ? 1 : 0);
    }
  }
}

/// Writes the keys of up to kPlaceBlock points.
template <bool exact>
void placeKeys(const float* x, const float* y, std::size_t count, float inverse_cell, float shift,
               std::uint64_t* keys) {
  std::int32_t columns[kPlaceBlock], rows[kPlaceBlock];
  cellsOf<exact>(x, count, inverse_cell, shift, columns);
  cellsOf<exact>(y, count, inverse_cell, shift, rows);
  for (std::size_t k = 0; k < count; ++k) {
    keys[k] = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(columns[k])) << 32) |
              static_cast<std::uint32_t>(rows[k]);
  }
}

/// Returns whether the numbers of cells would not fit into a key, so that coordinates are compared exactly.
inline bool hasTooManyCells(const std::vector<float>& x, const std::vector<float>& y, double cell) {
  constexpr double kMaxCells = 1e9;
  return !(std::max(largestMagnitude(x), largestMagnitude(y)) / cell < kMaxCells);
}

/// Returns a number below 2^bits that looks random.
inline std::uint64_t hashOf(std::uint64_t key, unsigned bits) {
  return ((key ^ (key >> 29)) * 0x9E3779B97F4A7C15U) >> (64 - bits);
}

/// Returns the bits of the numbers below a power of two that is at least `count`.
inline unsigned bitsFor(std::size_t count, unsigned smallest) {
  unsigned bits = smallest;
  while ((std::size_t{1} << bits) < count) ++bits;
  return bits;
}

}  // namespace corrsel::core
