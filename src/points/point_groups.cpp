#include "points/point_groups.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/largest_magnitude.h"

namespace corrsel::core {
namespace {

std::uint32_t bitsOf(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

constexpr std::size_t kBlock = 64;

/// Writes the numbers of the cells of some coordinates, or, where such numbers would be too large, the bits
/// of the coordinates.
/// @param shift  0.5 rounds to the nearest multiple of the cell, 0 rounds down
template <bool exact>
void cellsOf(const float* values, std::size_t count, float inverse_cell, float shift, std::int32_t* cells) {
  for (std::size_t k = 0; k < count; ++k) {
    if constexpr (exact) {
      cells[k] = static_cast<std::int32_t>(bitsOf(values[k] + 0.0F));
    } else {
      // std::floor() would be a call without SSE4.1.
      const float shifted = values[k] * inverse_cell + shift;
      const auto truncated = static_cast<std::int32_t>(shifted);
      cells[k] = truncated - (static_cast<float>(truncated) > shifted ? 1 : 0);
    }
  }
}

}  // namespace

void PointGroups::number(const std::vector<float>& x, const std::vector<float>& y, double cell,
                         Rounding rounding) {
  constexpr double kMaxCells = 1e9;
  const double largest = std::max(largestMagnitude(x), largestMagnitude(y));
  const auto inverse = static_cast<float>(1.0 / cell);
  const float shift = rounding == Rounding::kNearest ? 0.5F : 0.0F;
  if (largest / cell < kMaxCells) {
    numberCells<false>(x, y, inverse, shift);
  } else {
    numberCells<true>(x, y, inverse, shift);
  }
}

template <bool exact>
void PointGroups::numberCells(const std::vector<float>& x, const std::vector<float>& y, float inverse_cell,
                              float shift) {
  if (x.size() < std::numeric_limits<std::uint16_t>::max()) {
    numberWith<exact>(x, y, inverse_cell, shift, short_slots_);
  } else {
    numberWith<exact>(x, y, inverse_cell, shift, slots_);
  }
}

template <bool exact, class Slot>
void PointGroups::numberWith(const std::vector<float>& x, const std::vector<float>& y, float inverse_cell,
                             float shift, std::vector<Slot>& table) {
  constexpr Slot kEmpty = std::numeric_limits<Slot>::max();
  const std::size_t n = x.size();
  unsigned bits = 4;
  while ((std::size_t{1} << bits) < 2 * n) ++bits;
  table.assign(std::size_t{1} << bits, kEmpty);
  for (std::vector<std::uint32_t>* column : {&of, &sizes}) column->resize(n);
  keys_.resize(n);
  // A hash table with open addressing. The groups are numbered in the order of their first appearance.
  Slot* const slots = table.data();
  std::uint64_t* const keys = keys_.data();
  const std::size_t last = table.size() - 1;
  std::uint32_t groups = 0;
  // The slots of a block of points are fetched before the first of them is needed.
  std::int32_t columns[kBlock], rows[kBlock];
  std::uint64_t block_keys[kBlock];
  std::size_t block_slots[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    cellsOf<exact>(x.data() + begin, count, inverse_cell, shift, columns);
    cellsOf<exact>(y.data() + begin, count, inverse_cell, shift, rows);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint64_t key = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(columns[k])) << 32) |
                                static_cast<std::uint32_t>(rows[k]);
      block_keys[k] = key;
      block_slots[k] = ((key ^ (key >> 29)) * 0x9E3779B97F4A7C15U) >> (64 - bits);
      __builtin_prefetch(slots + block_slots[k]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint64_t key = block_keys[k];
      std::size_t slot = block_slots[k];
      while (slots[slot] != kEmpty && keys[slots[slot]] != key) slot = (slot + 1) & last;
      std::uint32_t group = slots[slot];
      if (group == kEmpty) {
        group = groups++;
        slots[slot] = static_cast<Slot>(group);
        keys[group] = key;
        sizes[group] = 0;
      }
      of[begin + k] = group;
      ++sizes[group];
    }
  }
  sizes.resize(groups);
}

}  // namespace corrsel::core
