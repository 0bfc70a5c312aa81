#pragma once

#include <algorithm>
#include <cstddef>

namespace corrsel::core {

/// A grid of equal cells over a rectangle, numbered row by row. The outer cells are open-ended, so that every
/// point has a cell.
struct CellGrid {
  double left = 0, top = 0;                ///< corner of the first cell, px
  double cell_width = 1, cell_height = 1;  ///< px
  int columns = 1, rows = 1;

  /// Square cells that cover a rectangle; those at the right and at the bottom may reach beyond it.
  static CellGrid covering(double left, double top, double width, double height, double cell) {
    return {left, top, cell, cell, static_cast<int>(width / cell) + 1, static_cast<int>(height / cell) + 1};
  }

  /// A position, in cells, as one of `count` cells; 0 for NaN.
  static int clamped(double position, int count) {
    return position > 0 ? static_cast<int>(std::min(position, static_cast<double>(count - 1))) : 0;
  }

  int column(double x) const { return clamped((x - left) / cell_width, columns); }
  int row(double y) const { return clamped((y - top) / cell_height, rows); }
  std::size_t cells() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t number(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  std::size_t cell(double x, double y) const { return number(column(x), row(y)); }
};

}  // namespace corrsel::core
