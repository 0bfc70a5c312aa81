#include <gtest/gtest.h>

#include "adelaide_counts.h"
#include "corrsel/selectors/significant.h"
#include "search/significance.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// The test as it is defined, with neighbours by sorting. @pre no two distances are equal
Mask byDefinition(const Correspondences& m, const SignificantOptions& o) {
  const auto left = [&m](std::size_t i) { return cv::Point2d(m.left_x[i], m.left_y[i]); };
  const auto right = [&m](std::size_t i) { return cv::Point2d(m.right_x[i], m.right_y[i]); };
  std::vector<std::size_t> members(m.size());
  std::iota(members.begin(), members.end(), 0U);
  Mask mask;
  for (int pass = 0; pass < 2; ++pass) {
    mask.assign(m.size(), 0);
    for (std::size_t i = 0; i < m.size(); ++i) {
      std::vector<std::pair<double, std::size_t>> near;
      for (const std::size_t j : members) {
        if (j != i) near.emplace_back(cv::norm(left(j) - left(i)), j);
      }
      std::sort(near.begin(), near.end());
      near.resize(std::min(near.size(), std::size_t(o.k)));
      std::size_t neighbours = 0, agreeing = 0;
      double chance = 0;
      for (const auto& [distance, j] : near) {
        if (distance < 1 || cv::norm(right(j) - right(i)) < 1) continue;
        const double reach = o.deformation * distance + o.slack;
        ++neighbours;
        agreeing += cv::norm(right(j) - right(i) - left(j) + left(i)) <= reach;
        chance += std::min(1.0, CV_PI * reach * reach / m.right_size.area());
      }
      const double log10_nfa =
          std::log10(double(m.size())) + log10BinomialTail(neighbours, agreeing, chance / double(neighbours));
      mask[i] = log10_nfa < o.cut;
    }
    members.clear();
    for (std::size_t i = 0; i < m.size(); ++i) {
      if (mask[i] != 0) members.push_back(i);
    }
  }
  return mask;
}

TEST(Significant, FollowsTheDefinition) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SceneOptions options{150 + 150 * seed, 0.3 + 0.1 * double(seed), 0.3 * double(seed), seed};
    Correspondences m = (seed % 2 ? homographyScene(options) : stereoScene(options)).matches;
    for (std::size_t i = 1; i < m.size(); i += 7)
      m.right_x[i] = m.right_x[i - 1], m.right_y[i] = m.right_y[i - 1];
    SignificantOptions significant;
    if (seed > 3) {
      significant.k = 16;
      significant.deformation = 0.3;
      significant.slack = 5;
      significant.cut = -2;
    }
    const Selection s = SignificantSelector(significant).select(m);
    const Mask expected = byDefinition(m, significant);
    for (std::size_t i = 0; i < m.size(); ++i)
      EXPECT_EQ(s.mask[i], expected[i]) << seed << " " << i << " " << s.score[i];
    EXPECT_GT(s.n_selected, 10u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
  }
}

TEST(Significant, CountsFalseAlarms) {
  const double expected[] = {0.90, -1.55, -4.25, -7.16, -10.25};
  for (std::size_t k = 1; k <= 5; ++k)
    EXPECT_NEAR(3 + log10BinomialTail(8, k, 1e-3), expected[k - 1], 0.02) << k;
}

TEST(Significant, FindsTheRightMatches) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene = homographyScene({1000, 0.5, 1.0, seed});
    const Selection s = createSelector("significant")->select(scene.matches);
    EXPECT_GT(quality(s.mask, scene.inlier).precision, 97);
    EXPECT_GT(quality(s.mask, scene.inlier).recall, 97);
    EXPECT_EQ(s.iterations, 2);
  }
}

/// At most one outlier is expected in the first pass; the second one has few neighbours to go by.
TEST(Significant, SelectsAlmostNothingWhereAllIsWrong) {
  std::size_t selected = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    selected +=
        createSelector("significant")->select(homographyScene({1000, 0.0, 0.0, seed}).matches).n_selected;
  EXPECT_LE(selected, 40u);
}

TEST(Significant, MatchesThatShareAPointAreNoNeighbours) {
  Scene scene = homographyScene({200, 0.0, 0.0, 3});
  Correspondences& m = scene.matches;
  for (std::size_t i = 0; i < 8; ++i) {
    // One left point close to others, one right point.
    m.left_x[i] = 300 + 2 * float(i);
    m.left_y[i] = 200;
    m.right_x[i] = 400;
    m.right_y[i] = 100;
  }
  const Mask mask = createSelector("significant", {{"slack", "20"}})->select(m).mask;
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(mask[i], 0) << i;
}

TEST(Significant, NamesWhatItCannotDecide) {
  const auto selector = createSelector("significant");
  EXPECT_EQ(selector->select(homographyScene({3, 1.0, 0.0, 1}).matches).message,
            "3 distinct matches, significant needs 4");
  Correspondences m = homographyScene({50, 1.0, 0.0, 1}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  EXPECT_EQ(selector->select(m).mask, Mask(50, 1));
  m.right_size = {};
  EXPECT_EQ(selector->select(m).mask, Mask(50, 1));
  m.right_x.assign(50, 1);
  m.right_y.assign(50, 2);
  EXPECT_EQ(selector->select(m).status, Status::kDegenerate);
}

TEST(Significant, ReachesTheExpectedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("significant");
  EXPECT_NEAR(q.precision, 97.1, 0.2);
  EXPECT_NEAR(q.recall, 98.5, 0.2);
  EXPECT_NEAR(q.f, 97.7, 0.2);
  expectCounts("significant",
               {{"barrsmith", {86, 75}},
                {"biscuit", {147, 146}},
                {"cubechips", {142, 141}},
                {"hartley", {124, 123}},
                {"unionhouse", {80, 78}}},
               2);
}

}  // namespace
}  // namespace corrsel::core
