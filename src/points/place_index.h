#pragma once

#include <cmath>
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
  /// @param side      of a cell, px; positive
  void clear(std::size_t expected, float side);

  /// @return the number of the point: points are counted from 0
  std::uint32_t add(float x, float y);

  /// The number of a point that is nearer than the side of a cell, or kNone. O(1) for few points per cell.
  std::uint32_t findWithin(float x, float y) const;
  bool isTaken(float x, float y) const { return findWithin(x, y) != kNone; }

  /// Calls visit(number) for all points within reach_x and reach_y of (x, y), and for some others, some of
  /// them twice, until it returns true. O(cells of the box and their points).
  /// @return whether it returned true
  template <class Visit>
  bool visitNear(double x, double y, double reach_x, double reach_y, const Visit& visit) const {
    return visitCells(cellOf(x - reach_x), cellOf(x + reach_x), cellOf(y - reach_y), cellOf(y + reach_y),
                      visit);
  }

 private:
  struct Point {
    float x, y;
    std::uint32_t next;  // in the list of the slot, counted from 1
  };

  template <class Visit>
  bool visitCells(std::int64_t left, std::int64_t right, std::int64_t top, std::int64_t bottom,
                  const Visit& visit) const {
    for (std::int64_t row = top; row <= bottom; ++row) {
      for (std::int64_t column = left; column <= right; ++column) {
        for (std::uint32_t i = first_[slot(column, row)]; i != 0; i = points_[i - 1].next)
          if (visit(i - 1)) return true;
      }
    }
    return false;
  }

  std::int64_t cellOf(double coordinate) const {
    return saturated(static_cast<float>(std::floor(coordinate / side_)));
  }
  std::size_t slot(std::int64_t column, std::int64_t row) const {
    const std::uint64_t cell = static_cast<std::uint64_t>(static_cast<std::uint32_t>(column)) << 32 |
                               static_cast<std::uint32_t>(row);
    return static_cast<std::size_t>(cell * 0x9E3779B97F4A7C15U >> 32) & (first_.size() - 1);
  }

  float side_ = 1;
  std::vector<std::uint32_t> first_ =
      std::vector<std::uint32_t>(1, 0);  // by slot: first point, counted from 1
  std::vector<Point> points_;
};

}  // namespace corrsel::core
