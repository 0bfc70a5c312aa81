#include <gtest/gtest.h>

#include "auto/leftover.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// 400 matches that do not move, and `moving` ones on a lattice of 10 px that move by 60 px.
struct TwoMotions {
  Correspondences matches;
  Mask local, still;

  explicit TwoMotions(int moving, float right_step = 10) {
    Random random(1);
    for (int i = 0; i < 400; ++i) {
      const cv::Point2d p = uniformPoint(random, 800, 600);
      matches.add(p, p);
    }
    for (int i = 0; i < moving; ++i) {
      const auto column = static_cast<float>(i % 5), row = static_cast<float>(i / 5);
      matches.add({400 + 10 * column, 300 + 10 * row}, {460 + right_step * column, 300 + right_step * row});
    }
    local.assign(matches.size(), 1);
    still.assign(matches.size(), 1);
    std::fill(still.begin() + 400, still.end(), 0);
  }
};

TEST(Leftover, FindsAGroupWithAMotionOfItsOwn) {
  const TwoMotions scene(50);
  Leftover leftover;
  leftover.assign(scene.matches);
  const std::size_t count = leftover.coherent(scene.local, scene.still);
  EXPECT_GE(count, 30U);
  EXPECT_LE(count, 50U);
  EXPECT_TRUE(leftover.isSizable(count, 400));
}

TEST(Leftover, ScatteredMatchesAreNotCoherent) {
  TwoMotions scene(0);
  Mask explained(400, 1);
  for (std::size_t i = 0; i < 400; i += 20) explained[i] = 0;
  Leftover leftover;
  leftover.assign(scene.matches);
  EXPECT_LE(leftover.coherent(scene.local, explained), 2U);
}

TEST(Leftover, OneRightPlaceCountsOnce) {
  const TwoMotions scene(50, 0);  // all end at the same right point
  Leftover leftover;
  leftover.assign(scene.matches);
  EXPECT_LE(leftover.coherent(scene.local, scene.still), 1U);
}

TEST(Leftover, WhatIsExplainedIsNotLeftOver) {
  const TwoMotions scene(50);
  Leftover leftover;
  leftover.assign(scene.matches);
  EXPECT_EQ(leftover.coherent(scene.local, Mask(scene.matches.size(), 1)), 0U);
  EXPECT_EQ(leftover.coherent(Mask(scene.matches.size(), 0), Mask(scene.matches.size(), 0)), 0U);
}

TEST(Leftover, IsSizableByThreeLimits) {
  TwoMotions scene(600);  // 1000 matches
  Leftover leftover;
  leftover.assign(scene.matches);
  EXPECT_FALSE(leftover.isSizable(5, 20));    // fewer than 6
  EXPECT_FALSE(leftover.isSizable(30, 900));  // 3.2 % of what is explained
  EXPECT_TRUE(leftover.isSizable(40, 900));   // 4.3 % of it, 40 % of the others
  EXPECT_FALSE(leftover.isSizable(18, 50));   // 1.9 % of what is not explained
  EXPECT_TRUE(leftover.isSizable(20, 50));    // 2.1 % of it
}

}  // namespace
}  // namespace corrsel::core
