#include "points/place_index.h"

namespace corrsel::core {

void PlaceIndex::clear(std::size_t expected, float side) {
  side_ = side;
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
  const std::int64_t column = cellOf(x), row = cellOf(y);
  std::uint32_t found = kNone;
  visitCells(column - 1, column + 1, row - 1, row + 1, [&](std::uint32_t number) {
    const float dx = points_[number].x - x, dy = points_[number].y - y;
    if (dx * dx + dy * dy < side_ * side_) found = number;
    return found != kNone;
  });
  return found;
}

}  // namespace corrsel::core
