#include "points/place_index.h"

namespace corrsel::core {

void PlaceIndex::clear(std::size_t expected, float reach) {
  constexpr double kCellSide = 4;  // in reaches: a search looks at one to four cells, at 2.25 in the mean
  reach_ = reach;
  cells_per_pixel_ = 1 / (kCellSide * double{reach});
  std::size_t size = 16;
  while (size < 2 * expected) size *= 2;
  first_.assign(size, 0);
  points_.clear();
}

std::uint32_t PlaceIndex::add(float x, float y) {
  std::uint32_t& first = first_[slot(cellOf(x), cellOf(y))];
  points_.push_back({x, y, first});
  first = static_cast<std::uint32_t>(points_.size());
  return first - 1;
}

std::uint32_t PlaceIndex::findWithin(float x, float y) const {
  std::uint32_t found = kNone;
  visitNear(x, y, reach_, reach_, [&](std::uint32_t number) {
    const float dx = points_[number].x - x, dy = points_[number].y - y;
    if (dx * dx + dy * dy < reach_ * reach_) found = number;
    return found != kNone;
  });
  return found;
}

}  // namespace corrsel::core
