#include <gtest/gtest.h>

#include <algorithm>

#include "auto/plausibility.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// 100 core matches that move by (30, 0), then one that does, too, and one that moves by (30, 200).
struct Surroundings {
  Correspondences matches;
  std::vector<LinearMap> maps;
  Mask core;

  Surroundings() {
    Random random(1);
    for (int i = 0; i < 100; ++i) {
      const cv::Point2d p = uniformPoint(random, 400, 300);
      matches.add(p, p + cv::Point2d(30, 0));
    }
    matches.add({200, 150}, {233, 152});
    matches.add({200, 150}, {230, 350});
    maps.assign(102, LinearMap{1, 0, 0, 1});
    core.assign(102, 1);
    core[100] = core[101] = 0;
  }
};

TEST(Plausibility, RemovesWhatNoNeighbourPredicts) {
  const Surroundings scene;
  Mask mask(102, 1);
  Plausibility().filter(scene.matches, scene.maps, scene.core, mask);
  EXPECT_EQ(mask[100], 1);
  EXPECT_EQ(mask[101], 0);
  EXPECT_EQ(std::count(mask.begin(), mask.end(), 1), 101);
}

TEST(Plausibility, AddsNothing) {
  const Surroundings scene;
  Mask mask(102, 0);
  Plausibility().filter(scene.matches, scene.maps, scene.core, mask);
  EXPECT_EQ(std::count(mask.begin(), mask.end(), 1), 0);
}

TEST(Plausibility, UsesTheMapsOfTheNeighbours) {
  // The match lies 500 px from all core matches and moves like an enlargement by 2.
  Surroundings scene;
  scene.matches.left_x[100] = 900;
  scene.matches.right_x[100] = 200 + 2 * (900 - 200) + 30;
  Mask mask(102, 1);
  Plausibility().filter(scene.matches, scene.maps, scene.core, mask);
  EXPECT_EQ(mask[100], 0);
  mask[100] = 1;
  scene.maps.assign(102, LinearMap{2, 0, 0, 2});
  Plausibility().filter(scene.matches, scene.maps, scene.core, mask);
  EXPECT_EQ(mask[100], 1);
}

TEST(Plausibility, KeepsEverythingWithoutACore) {
  const Surroundings scene;
  Mask mask(102, 1);
  Plausibility().filter(scene.matches, scene.maps, Mask(102, 0), mask);
  EXPECT_EQ(std::count(mask.begin(), mask.end(), 1), 102);
}

}  // namespace
}  // namespace corrsel::core
