#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// A row number and what it is sorted by.
struct KeyedRow {
  std::uint32_t key, row;
};

/// A whole number that compares like the value does; -0 and 0 are one. @pre not NaN
inline std::uint32_t sortKey(float value) {
  const float positive_zero = value + 0.0F;
  std::uint32_t bits = 0;
  std::memcpy(&bits, &positive_zero, sizeof bits);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

/// Sorts by key, equal keys as they come. O(N), with `scratch` as long as `rows`.
void radixSort(std::vector<KeyedRow>& rows, std::vector<KeyedRow>& scratch);

/// Negative, 0 or positive as match a stands before, with or behind match b, by left x, left y, right x,
/// right y.
int compareCoordinates(const Correspondences& matches, std::uint32_t a, std::uint32_t b);

/// Writes all rows in the order of their coordinates, key = sortKey(left x); equal matches by their
/// descriptor distances, then as they come. What is computed in this order does not depend on the order of
/// the input. O(N), or O(N log N) where most matches share their left x.
void sortByCoordinates(const Correspondences& matches, std::vector<KeyedRow>& rows,
                       std::vector<KeyedRow>& scratch);

}  // namespace corrsel::core
