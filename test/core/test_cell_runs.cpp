#include <gtest/gtest.h>

#include "points/cell_runs.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Points in the slots of a grid, and what a search finds.
struct Grid {
  CellRuns cells;
  std::vector<int> at_slot;  ///< number of the point, or -1

  Grid(const std::vector<float>& x, const std::vector<float>& y, double width, double height) {
    cells.build(x.data(), y.data(), x.size(), {0, 0}, {width, height});
    at_slot.assign(cells.slots(), -1);
    EXPECT_EQ(cells.slotOf().size(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::uint32_t slot = cells.slotOf()[i];
      EXPECT_LT(slot, at_slot.size());
      EXPECT_EQ(at_slot[slot], -1) << "two points share a slot";
      at_slot[slot] = int(i);
    }
  }

  /// How often every point is in the runs of a box.
  std::vector<int> found(double x, double y, double half_width, double half_height) const {
    std::vector<int> times(cells.slotOf().size(), 0);
    SupportRun runs[CellRuns::kMostRows];
    const std::size_t count = cells.find(x, y, half_width, half_height, runs);
    for (std::size_t r = 0; r < count; ++r) {
      EXPECT_EQ(runs[r].begin % SupportRun::kMultiple, 0u);
      EXPECT_EQ(runs[r].end % SupportRun::kMultiple, 0u);
      for (std::uint32_t slot = runs[r].begin; slot < runs[r].end; ++slot) {
        if (at_slot[slot] >= 0) ++times[std::size_t(at_slot[slot])];
      }
    }
    return times;
  }
};

TEST(CellRuns, FindAllPointsOfABoxOnce) {
  Random random(1);
  for (const std::size_t n : {1, 5, 100, 2000, 30000}) {
    std::vector<float> x(n), y(n);
    for (std::size_t i = 0; i < n; ++i) {
      // Some lie outside of the stated bounds.
      x[i] = float(random.uniform(-50, 850));
      y[i] = float(random.uniform(-50, 650));
    }
    const Grid grid(x, y, 800, 600);
    EXPECT_EQ(grid.cells.slots() % SupportRun::kMultiple, 0u);
    std::size_t outside = 0, visited = 0;
    for (int query = 0; query < 20; ++query) {
      const double qx = random.uniform(-20, 820), qy = random.uniform(-20, 620);
      const double w = random.uniform(0, 200), h = random.uniform(0, 200);
      const std::vector<int> times = grid.found(qx, qy, w, h);
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
    const std::vector<int> all = grid.found(400, 300, 1e30, 1e300);
    EXPECT_EQ(std::count(all.begin(), all.end(), 1), std::ptrdiff_t(n));
  }
}

TEST(CellRuns, EveryPointInOneCellOrNone) {
  const std::vector<float> same(1000, 7.0F), none;
  const Grid grid(same, same, 800, 600);
  const std::vector<int> times = grid.found(7, 7, 0, 0);
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), 1000);
  const Grid flat(same, same, 0, 0);
  const std::vector<int> in_flat = flat.found(7, 7, 0, 0);
  EXPECT_EQ(std::count(in_flat.begin(), in_flat.end(), 1), 1000);
  CellRuns empty;
  empty.build(none.data(), none.data(), 0, {0, 0}, {1, 1});
  SupportRun runs[CellRuns::kMostRows];
  EXPECT_EQ(empty.slots(), 0u);
  EXPECT_EQ(empty.find(0, 0, 1, 1, runs), 0u);
}

TEST(CellRuns, ASecondBuildForgetsTheFirst) {
  Random random(2);
  std::vector<float> x(500), y(500);
  for (std::size_t i = 0; i < 500; ++i) {
    x[i] = float(random.uniform(0, 100));
    y[i] = float(random.uniform(0, 100));
  }
  CellRuns again;
  again.build(y.data(), x.data(), 500, {-5, 0}, {200, 300});
  again.build(x.data(), y.data(), 300, {0, 0}, {100, 100});
  CellRuns once;
  once.build(x.data(), y.data(), 300, {0, 0}, {100, 100});
  EXPECT_EQ(again.slotOf(), once.slotOf());
  EXPECT_EQ(again.slots(), once.slots());
}

}  // namespace
}  // namespace corrsel::core
