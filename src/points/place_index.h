#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/saturated.h"

namespace corrsel::core {

/// Points that are added one by one and found by their place, anywhere in the plane: a hash table of cells.
class PlaceIndex {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// Removes all points and keeps the memory.
  /// @param expected  points that will be added; more make it slower
  /// @param reach     of findWithin, px; positive
  void clear(std::size_t expected, float reach);

  /// @return the number of the point: points are counted from 0
  std::uint32_t add(float x, float y);

  /// The number of a point that is nearer than the reach, or kNone. O(1) for few points within four times the
  /// reach.
  std::uint32_t findWithin(float x, float y) const;
  bool isTaken(float x, float y) const { return findWithin(x, y) != kNone; }

  /// Calls visit(number) for all points within reach_x and reach_y of (x, y), and for some others, some of
  /// them twice, until it returns true. O(cells of the box and their points).
  /// @return whether it returned true
  template <class Visit>
  bool visitNear(double x, double y, double reach_x, double reach_y, const Visit& visit) const {
    const std::int64_t left = cellOf(x - reach_x), right = cellOf(x + reach_x);
    const std::int64_t top = cellOf(y - reach_y), bottom = cellOf(y + reach_y);
    for (std::int64_t row = top; row <= bottom; ++row) {
      for (std::int64_t column = left; column <= right; ++column) {
        for (std::uint32_t i = first_[slot(column, row)]; i != 0; i = points_[i - 1].next)
          if (visit(i - 1)) return true;
      }
    }
    return false;
  }

 private:
  struct Point {
    float x, y;
    std::uint32_t next;  // in the list of the slot, counted from 1
  };

  /// Grows with the coordinate, so that no point of a box is outside of its cells.
  std::int64_t cellOf(double coordinate) const {
    const auto cells = static_cast<float>(coordinate * cells_per_pixel_);
    const std::int64_t towards_zero = saturated(cells);
    return towards_zero - (static_cast<float>(towards_zero) > cells ? 1 : 0);
  }
  std::size_t slot(std::int64_t column, std::int64_t row) const {
    const std::uint64_t cell = static_cast<std::uint64_t>(static_cast<std::uint32_t>(column)) << 32 |
                               static_cast<std::uint32_t>(row);
    return static_cast<std::size_t>(cell * 0x9E3779B97F4A7C15U >> 32) & (first_.size() - 1);
  }

  float reach_ = 1;
  double cells_per_pixel_ = 1;
  std::vector<std::uint32_t> first_ =
      std::vector<std::uint32_t>(1, 0);  // by slot: first point, counted from 1
  std::vector<Point> points_;
};

}  // namespace corrsel::core
