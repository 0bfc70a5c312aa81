#include "points/point_cells.h"

namespace corrsel::core {

void PointCells::build(const float* x, const float* y, std::size_t count, const CellGrid& grid,
                       std::uint32_t multiple) {
  grid_ = grid;
  const auto columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  const std::size_t stride = columns + 1;
  start_.assign(rows * stride + 1, 0);
  cell_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int row = grid.row(y[i]);
    cell_[i] =
        static_cast<std::uint32_t>(grid.number(grid.column(x[i]), row) + static_cast<std::size_t>(row));
    ++start_[cell_[i]];
  }
  std::uint32_t next = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t entry = row * stride; entry < (row + 1) * stride; ++entry) {
      const std::uint32_t in_cell = start_[entry];
      start_[entry] = next;
      next += in_cell;
    }
    next = (next + multiple - 1) & ~(multiple - 1);
  }
  start_.back() = next;
  slot_.resize(count);
  for (std::size_t i = 0; i < count; ++i) slot_[i] = start_[cell_[i]]++;
  // Every entry of a cell is now its end, i.e. the start of the next cell of the row.
  for (std::size_t row = 0; row < rows; ++row) {
    std::uint32_t* const entries = start_.data() + row * stride;
    for (std::size_t column = columns; column > 0; --column) entries[column] = entries[column - 1];
    entries[0] = row == 0 ? 0 : (start_[row * stride - 1] + multiple - 1) & ~(multiple - 1);
  }
}

}  // namespace corrsel::core
