#include "points/occupied_cells.h"

#include <algorithm>
#include <cmath>

#include "base/saturated.h"

namespace corrsel::core {
namespace {

constexpr float kCell = 8.0F;  // px

}  // namespace

std::size_t OccupiedCells::count(const std::vector<float>& x, const std::vector<float>& y,
                                 const std::vector<std::uint8_t>& mask) {
  cells_.clear();
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    const auto column = static_cast<std::uint32_t>(saturated(std::floor(x[i] / kCell)));
    const auto row = static_cast<std::uint32_t>(saturated(std::floor(y[i] / kCell)));
    cells_.push_back(static_cast<std::uint64_t>(column) << 32 | row);
  }
  std::sort(cells_.begin(), cells_.end());
  return static_cast<std::size_t>(std::unique(cells_.begin(), cells_.end()) - cells_.begin());
}

std::size_t OccupiedCells::count(const Correspondences& matches, const std::vector<std::uint8_t>& mask) {
  return std::min(count(matches.left_x, matches.left_y, mask), count(matches.right_x, matches.right_y, mask));
}

}  // namespace corrsel::core
