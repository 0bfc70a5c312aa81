#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/selection.h"

namespace corrsel::core {

/// The values of some rows as values of all n rows. O(n).
template <class Value>
std::vector<Value> spread(const std::vector<Value>& values, const std::vector<std::uint32_t>& rows,
                          std::size_t n, Value of_others) {
  std::vector<Value> result(n, of_others);
  for (std::size_t i = 0; i < rows.size(); ++i) result[rows[i]] = values[i];
  return result;
}

/// A selection among some rows of n matches as one among all of them. The other matches are rejected: their
/// score is NaN, their group -1 and their probability 0. n_input becomes n; everything else stays as it is.
/// O(n).
/// @param rows  ascending; as many as `some` has elements in its mask
Selection spreadSelection(Selection some, const std::vector<std::uint32_t>& rows, std::size_t n);

}  // namespace corrsel::core
