#include <gtest/gtest.h>

#include "points/point_cells.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr std::uint32_t kMultiple = 16;

/// Points in the slots of a grid, and what a search finds.
struct Sorted {
  PointCells cells;
  std::vector<int> at_slot;  ///< number of the point, or -1

  Sorted(const std::vector<float>& x, const std::vector<float>& y, const CellGrid& grid,
         std::uint32_t multiple) {
    cells.build(x.data(), y.data(), x.size(), grid, multiple);
    at_slot.assign(cells.slots(), -1);
    EXPECT_EQ(cells.slotOf().size(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::uint32_t slot = cells.slotOf()[i];
      EXPECT_LT(slot, at_slot.size());
      EXPECT_EQ(at_slot[slot], -1) << "two points share a slot";
      at_slot[slot] = int(i);
    }
  }

  /// How often every point is in the runs of a box, after rounding to whole multiples.
  std::vector<int> found(double x, double y, double half_width, double half_height,
                         std::uint32_t multiple) const {
    std::vector<int> times(cells.slotOf().size(), 0);
    cells.visitRuns(x, y, half_width, half_height, [&](std::uint32_t begin, std::uint32_t end) {
      if (begin == end) return;
      begin = begin / multiple * multiple;
      end = (end + multiple - 1) / multiple * multiple;
      for (std::uint32_t slot = begin; slot < end; ++slot) {
        if (at_slot[slot] >= 0) ++times[std::size_t(at_slot[slot])];
      }
    });
    return times;
  }
};

TEST(PointCells, RunsHoldAllPointsOfABoxOnce) {
  Random random(1);
  for (const std::uint32_t multiple : {1U, kMultiple}) {
    for (const std::size_t n : {1, 5, 100, 2000, 30000}) {
      std::vector<float> x(n), y(n);
      for (std::size_t i = 0; i < n; ++i) {
        // Some lie outside of the grid.
        x[i] = float(random.uniform(-50, 850));
        y[i] = float(random.uniform(-50, 650));
      }
      const int side = std::max(1, int(std::sqrt(double(n)) / 4));
      const Sorted sorted(x, y, {0, 0, 800.0 / side, 600.0 / side, side, side}, multiple);
      EXPECT_EQ(sorted.cells.slots() % multiple, 0u);
      std::size_t outside = 0, visited = 0;
      for (int query = 0; query < 20; ++query) {
        const double qx = random.uniform(-20, 820), qy = random.uniform(-20, 620);
        const double w = random.uniform(0, 200), h = random.uniform(0, 200);
        const std::vector<int> times = sorted.found(qx, qy, w, h, multiple);
        for (std::size_t i = 0; i < n; ++i) {
          const bool inside = std::abs(x[i] - qx) <= w && std::abs(y[i] - qy) <= h;
          ASSERT_LE(times[i], 1);
          if (inside) {
            ASSERT_EQ(times[i], 1) << n << " points, number " << i;
          } else {
            ++outside;
            visited += std::size_t(times[i]);
          }
        }
      }
      if (n >= 2000) {
        EXPECT_LT(visited, outside / 4) << "runs must hold few other points";
      }
      const std::vector<int> all = sorted.found(400, 300, 1e30, 1e300, multiple);
      EXPECT_EQ(std::count(all.begin(), all.end(), 1), std::ptrdiff_t(n));
    }
  }
}

TEST(PointCells, PointsOfACellKeepTheirOrder) {
  Random random(3);
  std::vector<float> x(300), y(300);
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = float(random.uniform(0, 100));
    y[i] = float(random.uniform(0, 100));
  }
  const CellGrid grid = CellGrid::covering(0, 0, 99, 99, 25);
  const Sorted sorted(x, y, grid, 1);
  std::size_t cell = 0, points = 0;
  sorted.cells.visitCells([&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t slot = begin; slot < end; ++slot, ++points) {
      const auto i = std::size_t(sorted.at_slot[slot]);
      EXPECT_EQ(grid.cell(x[i], y[i]), cell);
      if (slot > begin) {
        EXPECT_LT(sorted.at_slot[slot - 1], sorted.at_slot[slot]);
      }
    }
    ++cell;
  });
  EXPECT_EQ(cell, grid.cells());
  EXPECT_EQ(points, x.size());
}

TEST(PointCells, EveryPointInOneCellOrNone) {
  const std::vector<float> same(1000, 7.0F);
  const Sorted sorted(same, same, {0, 0, 100, 100, 8, 6}, kMultiple);
  const std::vector<int> times = sorted.found(7, 7, 0, 0, kMultiple);
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), 1000);
  PointCells empty;
  empty.build(nullptr, nullptr, 0, {0, 0, 1, 1, 3, 3}, kMultiple);
  EXPECT_EQ(empty.slots(), 0u);
  empty.visitRuns(0, 0, 1, 1, [](std::uint32_t begin, std::uint32_t end) { EXPECT_EQ(begin, end); });
}

TEST(PointCells, ASecondBuildForgetsTheFirst) {
  Random random(2);
  std::vector<float> x(500), y(500);
  for (std::size_t i = 0; i < 500; ++i) {
    x[i] = float(random.uniform(0, 100));
    y[i] = float(random.uniform(0, 100));
  }
  PointCells again, once;
  again.build(y.data(), x.data(), 500, {-5, 0, 20, 30, 10, 10}, kMultiple);
  again.build(x.data(), y.data(), 300, {0, 0, 20, 20, 5, 5}, kMultiple);
  once.build(x.data(), y.data(), 300, {0, 0, 20, 20, 5, 5}, kMultiple);
  EXPECT_EQ(again.slotOf(), once.slotOf());
  EXPECT_EQ(again.slots(), once.slots());
}

}  // namespace
}  // namespace corrsel::core
