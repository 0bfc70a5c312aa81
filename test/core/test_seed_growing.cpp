#include <gtest/gtest.h>

#include "search/seed_growing.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kDiagonal = 1000;
constexpr LinearMap kIdentity = {1, 0, 0, 1};

/// 100 matches that stay, 100 that move by 80 px, and one that moves alone.
struct TwoGroups {
  Correspondences matches;
  std::vector<float> weights;
  std::vector<LinearMap> maps;
  std::vector<std::uint32_t> seeds;

  TwoGroups() {
    Random random(1);
    for (int i = 0; i < 201; ++i) {
      const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
      matches.add(left, left + cv::Point2d(i == 200 ? -300 : i < 100 ? 0 : 80, 0));
      seeds.push_back(static_cast<std::uint32_t>(i));
    }
    weights.assign(seeds.size(), 1);
    maps.assign(seeds.size(), kIdentity);
  }
};

TEST(SeedGrowing, PassesOverSeedsThatSupportAnEarlierMap) {
  const TwoGroups groups;
  SeedGrowing growing;
  growing.start(groups.matches, groups.weights, kDiagonal, groups.seeds, groups.maps);
  int standing = 0, moving = 0, seeds = 0;
  while (growing.next()) {
    ++seeds;
    if (growing.map() == nullptr) continue;
    const double shift = (*growing.map())(0, 2);
    (shift < 40 ? standing : moving) += 1;
    EXPECT_NEAR(shift, shift < 40 ? 0 : 80, 1);
  }
  EXPECT_GT(standing, 0);
  EXPECT_GT(moving, 0);
  EXPECT_LT(seeds, 40)
      << "of 201: most support a map that was grown before, from a seed within a quarter of the diagonal";
  EXPECT_EQ(growing.map(), nullptr) << "there is none after the last seed";
}

TEST(SeedGrowing, TakesOnlySeedsAndBeginsAnew) {
  TwoGroups groups;
  groups.seeds = {200};
  SeedGrowing growing;
  for (int repetition = 0; repetition < 2; ++repetition) {
    growing.start(groups.matches, groups.weights, kDiagonal, groups.seeds, groups.maps);
    EXPECT_TRUE(growing.next());
    EXPECT_EQ(growing.map(), nullptr) << "nothing moves with the only seed";
    EXPECT_FALSE(growing.next());
  }
}

}  // namespace
}  // namespace corrsel::core
