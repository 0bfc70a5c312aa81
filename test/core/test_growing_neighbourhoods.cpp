#include <gtest/gtest.h>

#include <set>

#include "reference/growing_neighbourhoods.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(ProgressiveNapsac, GoldenGrowth) {
  std::vector<std::uint64_t> growth;
  GrowingNeighbourhoods::growth(1000, 4, 500, growth);
  ASSERT_EQ(growth.size(), 1000u);
  const std::pair<std::size_t, std::uint64_t> golden[] = {{3, 1},    {4, 2},     {10, 8},     {50, 48},
                                                          {100, 98}, {500, 498}, {1000, 1182}};
  for (const auto& [n, last] : golden) EXPECT_EQ(growth[n - 1], last) << n;
}

/// Matches on a lattice, which a shift moves.
Correspondences lattice(int side) {
  Correspondences m;
  for (int i = 0; i < side * side; ++i) {
    const cv::Point2f p(static_cast<float>(10 * (i % side)), static_cast<float>(10 * (i / side)));
    m.add(p, p + cv::Point2f(5, 7));
  }
  return m;
}

TEST(ProgressiveNapsac, SamplesAreNearTheBestMatches) {
  constexpr int kSide = 64;
  constexpr std::size_t kCount = kSide * kSide, kSample = 4;
  const NormalizedMatches matches = normalizeMatches(lattice(kSide));
  const std::vector<std::uint32_t> order = permutation(kCount, 3);
  std::vector<std::size_t> rank(kCount);
  for (std::size_t i = 0; i < kCount; ++i) rank[order[i]] = i;
  GrowingNeighbourhoods near;
  near.build(matches, order, kSample);
  EXPECT_EQ(near.samples(), kCount / 2);
  Random random(1);
  std::uint32_t sample[kSample];
  std::size_t narrow = 0;
  for (std::size_t draw = 0; draw < kCount / 2; ++draw) {
    ASSERT_TRUE(near.draw(random, static_cast<std::uint32_t>(draw), sample));
    EXPECT_EQ(std::set<std::uint32_t>(sample, sample + kSample).size(), kSample);
    EXPECT_EQ(sample[kSample - 1], order[draw]);
    // The neighbour before it is the last of them by quality.
    EXPECT_GT(rank[sample[kSample - 2]], rank[sample[0]]);
    EXPECT_GT(rank[sample[kSample - 2]], rank[sample[1]]);
    bool one_cell = true;
    for (const std::uint32_t k : sample) {
      one_cell =
          one_cell && k % kSide / 4 == order[draw] % kSide / 4 && k / kSide / 4 == order[draw] / kSide / 4;
    }
    narrow += one_cell ? 1 : 0;
  }
  // The finest cells hold 16 matches, as many as few neighbourhoods outgrow.
  EXPECT_GT(narrow, kCount / 2 * 9 / 10);
}

TEST(ProgressiveNapsac, NeighbourhoodsGrowAndUseCoarserCells) {
  constexpr std::size_t kCount = 400, kSample = 4;
  const NormalizedMatches matches = normalizeMatches(lattice(20));
  const std::vector<std::uint32_t> order = permutation(kCount, 5);
  GrowingNeighbourhoods near;
  near.build(matches, order, kSample);
  Random random(1);
  std::uint32_t sample[kSample];
  // One match that is drawn again and again; the others of its samples are ever farther.
  double first = 0, last = 0;
  int draws = 0;
  for (; draws < 500; ++draws) {
    if (!near.draw(random, 0, sample)) break;
    double farthest = 0;
    for (const std::uint32_t k : sample) {
      const double dx = double(k % 20) - double(order[0] % 20), dy = double(k / 20) - double(order[0] / 20);
      farthest = std::max(farthest, std::hypot(dx, dy));
    }
    if (draws == 0) first = farthest;
    last = farthest;
  }
  EXPECT_LT(first, 3);
  EXPECT_GT(last, 5);
  // The coarsest cells hold a quarter of the lattice, and T'_n is n - 2 there.
  EXPECT_EQ(draws, 98);
}

TEST(ProgressiveNapsac, EqualPointsAreOneCell) {
  Correspondences m;
  for (int i = 0; i < 50; ++i) m.add({10, 10}, {20, 20});
  const NormalizedMatches matches = normalizeMatches(m);
  const std::vector<std::uint32_t> order = permutation(50, 5);
  GrowingNeighbourhoods near;
  near.build(matches, order, 7);
  Random random(1);
  std::uint32_t sample[7];
  ASSERT_TRUE(near.draw(random, 3, sample));
  EXPECT_EQ(std::set<std::uint32_t>(sample, sample + 7).size(), 7u);
  // Fewer matches than one neighbourhood needs exist nowhere.
  const std::vector<std::uint32_t> four = permutation(4, 1);
  near.build(normalizeMatches(lattice(2)), four, 4);
  EXPECT_FALSE(near.draw(random, 0, sample));
}

TEST(ProgressiveNapsac, FindsModels) {
  const Scene scene = homographyScene({1000, 0.4, 0.5, 3});
  const Selection found = createSelector("pnapsac")->select(scene.matches);
  EXPECT_EQ(found.status, Status::kOk) << found.message;
  EXPECT_GT(quality(found.mask, scene.inlier).f, 99);
  Correspondences bare = scene.matches;
  bare.distance.clear();
  const Selection uniform = createSelector("pnapsac")->select(bare);
  EXPECT_NE(uniform.message.find("instead of by Progressive NAPSAC"), std::string::npos) << uniform.message;
}

}  // namespace
}  // namespace corrsel::core
