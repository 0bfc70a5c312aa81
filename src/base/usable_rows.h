#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Whether a coordinate can be used: it is finite and at most 1e6 px, beyond which squared distances lose
/// their pixels in single precision.
inline bool isUsable(float coordinate) { return std::abs(coordinate) <= 1e6F; }

/// The rows whose four coordinates can be used, ascending.
inline std::vector<std::uint32_t> usableRows(const Correspondences& matches) {
  std::vector<std::uint32_t> rows;
  rows.reserve(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (isUsable(matches.left_x[i]) && isUsable(matches.left_y[i]) && isUsable(matches.right_x[i]) &&
        isUsable(matches.right_y[i])) {
      rows.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return rows;
}

}  // namespace corrsel::core
