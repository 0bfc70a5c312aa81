#include "points/occupied_cells.h"

#include <algorithm>

#include "points/length_unit.h"

namespace corrsel::core {
namespace {

constexpr double kCell = 8;  // units of the image

}  // namespace

std::size_t OccupiedCells::count(const std::vector<float>& x, const std::vector<float>& y, double unit,
                                 const std::vector<std::uint8_t>& mask) {
  x_.clear();
  y_.clear();
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    x_.push_back(x[i]);
    y_.push_back(y[i]);
  }
  groups_.number(x_, y_, kCell * unit, PointGroups::Rounding::kDown);
  return groups_.sizes.size();
}

std::size_t OccupiedCells::count(const Correspondences& matches, const std::vector<std::uint8_t>& mask) {
  const LengthUnits units = LengthUnits::of(matches).atLeast(1);
  return std::min(count(matches.left_x, matches.left_y, units.left, mask),
                  count(matches.right_x, matches.right_y, units.right, mask));
}

}  // namespace corrsel::core
