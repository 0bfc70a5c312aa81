#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// A row number and its sort key.
struct KeyedRow {
  std::uint32_t key, row;
};

/// Returns an integer that has the same order as the value; -0 and 0 are equal. @pre not NaN
inline std::uint32_t sortKey(float value) {
  const float positive_zero = value + 0.0F;
  std::uint32_t bits = 0;
  std::memcpy(&bits, &positive_zero, sizeof bits);
  // Inverts all bits of a negative number, and the sign of another one.
  return bits ^ ((0U - (bits >> 31)) | 0x80000000U);
}

/// Sorts by key and keeps the order of equal keys. O(N), with `scratch` as long as `rows`.
void radixSort(std::vector<KeyedRow>& rows, std::vector<KeyedRow>& scratch);

/// Compares two matches by left x, left y, right x, right y. Returns a negative number if a comes before b, 0
/// if they are equal, and a positive number otherwise.
int compareCoordinates(const Correspondences& matches, std::uint32_t a, std::uint32_t b);

/// Returns whether all points are equal; true for no points. O(N).
bool allEqual(const std::vector<float>& x, const std::vector<float>& y);

/// Writes all rows in the order of their coordinates, with key = sortKey(left x). Equal matches are ordered
/// by their descriptor distances, then by their probabilities, then as in the input. Results that are
/// computed in this order do not depend on the order of the input. O(N), or O(N log N) if most matches share
/// their left x.
void sortByCoordinates(const Correspondences& matches, std::vector<KeyedRow>& rows,
                       std::vector<KeyedRow>& scratch);

}  // namespace corrsel::core
