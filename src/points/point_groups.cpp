#include "points/point_groups.h"

#include <algorithm>
#include <limits>

#include "points/place_keys.h"

namespace corrsel::core {

void PointGroups::number(const std::vector<float>& x, const std::vector<float>& y, double cell,
                         Rounding rounding) {
  const auto inverse = static_cast<float>(1.0 / cell);
  const float shift = rounding == Rounding::kNearest ? 0.5F : 0.0F;
  if (hasTooManyCells(x, y, cell)) {
    numberCells<true>(x, y, inverse, shift);
  } else {
    numberCells<false>(x, y, inverse, shift);
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
  const unsigned bits = bitsFor(2 * n, 4);
  table.assign(std::size_t{1} << bits, kEmpty);
  for (std::vector<std::uint32_t>* column : {&of, &sizes}) column->resize(n);
  keys_.resize(n);
  // A hash table with open addressing. The groups are numbered in the order of their first appearance.
  Slot* const slots = table.data();
  std::uint64_t* const keys = keys_.data();
  const std::size_t last = table.size() - 1;
  std::uint32_t groups = 0;
  // The slots of a block of points are fetched before the first of them is needed.
  std::uint64_t block_keys[kPlaceBlock];
  std::size_t block_slots[kPlaceBlock];
  for (std::size_t begin = 0; begin < n; begin += kPlaceBlock) {
    const std::size_t count = std::min(kPlaceBlock, n - begin);
    placeKeys<exact>(x.data() + begin, y.data() + begin, count, inverse_cell, shift, block_keys);
    for (std::size_t k = 0; k < count; ++k) {
      block_slots[k] = hashOf(block_keys[k], bits);
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
