#include <gtest/gtest.h>

#include <limits>

#include "points/cell_grid.h"

namespace corrsel::core {
namespace {

TEST(CellGrid, NumbersTheCellsOfARectangleRowByRow) {
  const CellGrid grid = CellGrid::covering(-10, 20, 100, 50, 20);
  EXPECT_EQ(grid.columns, 6);
  EXPECT_EQ(grid.rows, 3);
  EXPECT_EQ(grid.cells(), 18u);
  EXPECT_EQ(grid.cell(-10, 20), 0u);
  EXPECT_EQ(grid.cell(9.99, 39.99), 0u);
  EXPECT_EQ(grid.cell(10, 20), 1u);
  EXPECT_EQ(grid.cell(-10, 40), 6u);
  EXPECT_EQ(grid.cell(90, 70), 17u);
}

TEST(CellGrid, OuterCellsAreOpenEnded) {
  const CellGrid grid{0, 0, 10, 5, 4, 3};
  EXPECT_EQ(grid.column(-1e30), 0);
  EXPECT_EQ(grid.column(1e30), 3);
  EXPECT_EQ(grid.row(-0.1), 0);
  EXPECT_EQ(grid.row(15), 2);
  EXPECT_EQ(grid.row(std::numeric_limits<double>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace corrsel::core
