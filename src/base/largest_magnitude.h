#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace corrsel::core {

/// The largest magnitude in a column; 0 if it is empty. @pre no NaN
inline float largestMagnitude(const std::vector<float>& column) {
  // Vectors are written out, because a compiler that must respect NaN does not form them. There are several,
  // so that the comparisons do not wait for one another.
  typedef float Floats __attribute__((vector_size(16)));
  typedef std::int32_t Bits __attribute__((vector_size(16)));
  constexpr std::size_t kWidth = 4, kVectors = 4, kStep = kWidth * kVectors;
  Floats largest[kVectors] = {};
  std::size_t i = 0;
  for (; i + kStep <= column.size(); i += kStep) {
    for (std::size_t k = 0; k < kVectors; ++k) {
      Bits bits;
      std::memcpy(&bits, column.data() + i + k * kWidth, sizeof bits);
      const Floats magnitude = reinterpret_cast<Floats>(bits & 0x7fffffff);
      largest[k] = largest[k] < magnitude ? magnitude : largest[k];
    }
  }
  float result = 0;
  for (const Floats& floats : largest) {
    for (std::size_t k = 0; k < kWidth; ++k) result = std::max(result, floats[k]);
  }
  for (; i < column.size(); ++i) result = std::max(result, std::abs(column[i]));
  return result;
}

}  // namespace corrsel::core
