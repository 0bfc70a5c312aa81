#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace corrsel::core {

/// The largest magnitude in a column; 0 if it is empty. @pre no NaN
inline float largestMagnitude(const std::vector<float>& column) {
  // Several maxima, so that the comparisons do not wait for one another and the compiler uses vectors.
  constexpr std::size_t kLanes = 16;
  float largest[kLanes] = {};
  const float* const values = column.data();
  std::size_t i = 0;
  for (; i + kLanes <= column.size(); i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const float magnitude = std::abs(values[i + k]);
      largest[k] = largest[k] < magnitude ? magnitude : largest[k];
    }
  }
  for (; i < column.size(); ++i) largest[0] = std::max(largest[0], std::abs(values[i]));
  return *std::max_element(largest, largest + kLanes);
}

}  // namespace corrsel::core
