#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/frame_map.h"

namespace corrsel::core {
namespace {

TEST(FrameMap, TakesTheLeftFrameToTheRightOne) {
  const AffineFrame left{4, 1, 100, -2, 3, 50}, right{5, -2, 7, 1, 6, 8};
  const auto map = frameMap(left, right);
  ASSERT_TRUE(map.has_value());
  for (std::size_t row = 0; row < 2; ++row) {
    for (std::size_t column = 0; column < 2; ++column) {
      const double product =
          double((*map)[2 * row]) * left[column] + double((*map)[2 * row + 1]) * left[3 + column];
      EXPECT_NEAR(product, right[3 * row + column], 1e-5);
    }
  }
}

TEST(FrameMap, RefusesFramesWithoutUse) {
  const AffineFrame good{5, 0, 0, 0, 5, 0};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const AffineFrame bad[] = {{0, 0, 0, 0, 0, 0},       {1, 2, 0, 2, 4, 0},
                             {nan, 0, 0, 0, 5, 0},     {51, 0, 0, 0, 5, 0},
                             {5001, 0, 0, 0, 5001, 0}, {0.0049F, 0, 0, 0, 0.0049F, 0},
                             {INFINITY, 0, 0, 0, 5, 0}};
  for (const AffineFrame& frame : bad) {
    EXPECT_FALSE(frameMap(good, frame).has_value()) << frame[0];
    EXPECT_FALSE(frameMap(frame, good).has_value()) << frame[0];
  }
  EXPECT_TRUE(frameMap(good, {49, 0, 0, 0, 5, 0}).has_value());
  EXPECT_TRUE(frameMap(good, {4900, 0, 0, 0, 4900, 0}).has_value());
}

TEST(FrameMap, ListsTheMatchesThatHaveOne) {
  Correspondences m;
  for (int i = 0; i < 3; ++i) m.add({0, 0}, {0, 0});
  m.left_frame.assign(3, {1, 0, 0, 0, 1, 0});
  m.right_frame = {{2, 0, 0, 0, 2, 0}, {0, 0, 0, 0, 0, 0}, {3, 0, 0, 0, 3, 0}};
  std::vector<LinearMap> maps(7);
  std::vector<std::uint32_t> rows(7);
  findFrameMaps(m, maps, rows);
  EXPECT_EQ(rows, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(maps, (std::vector<LinearMap>{{2, 0, 0, 2}, {0, 0, 0, 0}, {3, 0, 0, 3}}));
}

}  // namespace
}  // namespace corrsel::core
