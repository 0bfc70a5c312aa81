#include <gtest/gtest.h>

#include "adelaide_counts.h"
#include "corrsel/reference/ranks.h"
#include "reference/rank_distance.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// The numbers of the nearest members, the match itself included where it is one.
std::vector<std::uint32_t> nearest(const std::vector<float>& x, const std::vector<float>& y,
                                   const std::vector<std::uint32_t>& members, std::size_t i) {
  std::vector<std::pair<double, std::uint32_t>> sorted;
  for (const std::uint32_t j : members)
    sorted.emplace_back(std::hypot(double(x[j]) - x[i], double(y[j]) - y[i]), j);
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> result;
  for (const auto& [distance, j] : sorted) result.push_back(j);
  return result;
}

/// The distance of the first k members of two rankings.
double distanceOfFirst(int k, const std::vector<std::uint32_t>& left,
                       const std::vector<std::uint32_t>& right) {
  std::vector<std::uint8_t> places;
  for (int b = 0; b < k; ++b) {
    const auto found = std::find(left.begin(), left.begin() + k, right[std::size_t(b)]);
    places.push_back(found != left.begin() + k ? std::uint8_t(found - left.begin()) : RankDistance::kAbsent);
  }
  return RankDistance(k)(places.data());
}

TEST(Ranks, FollowsTheDefinition) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const SceneOptions options{200 * seed, 0.2 * double(seed), 0.3 * double(seed), seed};
    const Correspondences m = (seed % 2 ? homographyScene(options) : stereoScene(options)).matches;
    std::vector<std::uint32_t> members(m.size());
    std::iota(members.begin(), members.end(), 0U);
    Mask mask;
    for (int pass = 0; pass < 3; ++pass) {
      mask.assign(m.size(), 0);
      for (std::size_t i = 0; i < m.size(); ++i) {
        const auto left = nearest(m.left_x, m.left_y, members, i),
                   right = nearest(m.right_x, m.right_y, members, i);
        double cost = 0;
        for (const int k : {16, 14, 12}) cost += distanceOfFirst(k, left, right) / 3;
        mask[i] = cost <= (pass == 0 ? 0.8 : 0.35);
      }
      members = selectedRows(mask);
    }
    const Selection s = RanksSelector().select(m);
    EXPECT_EQ(s.mask, mask) << seed;
    EXPECT_EQ(s.iterations, 3);
    EXPECT_GT(s.n_selected, 10u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
  }
}

TEST(Ranks, FindsTheRightMatches) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene = homographyScene({1000, 0.6, 1.0, seed});
    const Quality q = quality(createSelector("ranks")->select(scene.matches).mask, scene.inlier);
    EXPECT_GT(q.precision, 93);
    EXPECT_GT(q.recall, 97);
  }
}

TEST(Ranks, NamesWhatItCannotDecide) {
  const auto selector = createSelector("ranks");
  EXPECT_EQ(selector->select(homographyScene({16, 1.0, 0.0, 1}).matches).message,
            "16 distinct matches, ranks needs 17");
  EXPECT_EQ(selector->select(homographyScene({17, 1.0, 0.0, 1}).matches).status, Status::kOk);
  Correspondences m = homographyScene({50, 1.0, 0.0, 1}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  EXPECT_EQ(selector->select(m).mask, Mask(50, 1));
  m.left_x.assign(50, 1);
  m.left_y.assign(50, 2);
  EXPECT_EQ(selector->select(m).status, Status::kDegenerate);
}

TEST(Ranks, ReachesTheExpectedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("ranks");
  EXPECT_NEAR(q.precision, 94.9, 0.2);
  EXPECT_NEAR(q.recall, 98.3, 0.2);
  EXPECT_NEAR(q.f, 96.4, 0.2);
  expectCounts("ranks", {{"barrsmith", {89, 72}}, {"biscuit", {147, 146}}, {"unionhouse", {92, 78}}}, 2);
}

}  // namespace
}  // namespace corrsel::core
