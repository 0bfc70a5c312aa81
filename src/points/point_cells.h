#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "points/cell_grid.h"

namespace corrsel::core {

/// Points sorted into the cells of a grid, row by row, so that all points near a place stand in a few runs of
/// slots. Points of one cell keep their order. The memory is kept between calls.
class PointCells {
 public:
  /// @param x, y  `count` finite coordinates
  /// @param multiple  a power of two; every row of cells is padded to a multiple of so many slots, so that
  /// runs that are rounded to whole multiples do not overlap
  /// O(count + cells).
  void build(const float* x, const float* y, std::size_t count, const CellGrid& grid,
             std::uint32_t multiple = 1);

  /// The number of slots, with the padding.
  std::size_t slots() const { return start_.empty() ? 0 : start_.back(); }

  /// The slot of every point.
  const std::vector<std::uint32_t>& slotOf() const { return slot_; }

  /// Calls visit(begin, end) for the slots of every cell.
  template <class Visit>
  void visitCells(const Visit& visit) const {
    for (int row = 0; row < grid_.rows; ++row) {
      for (int column = 0; column < grid_.columns; ++column) {
        const std::uint32_t* const cell = startOf(column, row);
        visit(cell[0], cell[1]);
      }
    }
  }

  /// Calls visit(begin, end) for one run of slots of every row of cells; the runs hold all points within
  /// half_width and half_height of (x, y), and some others. Runs may be empty.
  template <class Visit>
  void visitRuns(double x, double y, double half_width, double half_height, const Visit& visit) const {
    const int first = grid_.column(x - half_width), last = grid_.column(x + half_width);
    for (int row = grid_.row(y - half_height), end = grid_.row(y + half_height); row <= end; ++row)
      visit(*startOf(first, row), *startOf(last + 1, row));
  }

 private:
  /// The first slot of a cell, and behind it the end.
  const std::uint32_t* startOf(int column, int row) const {
    return start_.data() + grid_.number(column, row) + static_cast<std::size_t>(row);
  }

  CellGrid grid_;
  std::vector<std::uint32_t> start_;  // first slot of every cell; every row has one more entry, for its end
  std::vector<std::uint32_t> cell_, slot_;
};

}  // namespace corrsel::core
