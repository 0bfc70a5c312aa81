#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "corrsel/selectors/nnsr.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Selection select(const std::vector<float>& first, const std::vector<float>& second,
                 NnsrOptions options = {}) {
  Correspondences m;
  for (std::size_t i = 0; i < first.size(); ++i) m.add({float(i), 0}, {0, float(i)});
  m.distance = first;
  m.second_distance = second;
  return NnsrSelector(options).select(m);
}

TEST(Nnsr, SplitsTheRatiosOfDistances) {
  // The ratios 0.2, 0.25, 0.3 | 0.7, 0.75 part in the gap, not their squares.
  const Selection s = select({2, 5, 30, 7, 75}, {10, 20, 100, 10, 100});
  EXPECT_EQ(s.mask, (Mask{1, 1, 1, 0, 0}));
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(s.n_selected, 3u);
  const std::vector<float> expected = {0.8f, 0.75f, 0.7f, 0.3f, 0.25f};
  ASSERT_EQ(s.score.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_FLOAT_EQ(s.score[i], expected[i]);
  // Otsu's bin of 0.3 is number 76: its upper side is the threshold.
  EXPECT_EQ(s.message, "the threshold is 0.30078125");
}

TEST(Nnsr, RejectsMatchesWithoutARatioAndLeavesThemOutOfTheThreshold) {
  const std::vector<float> first = {2, 5, 30, 7, 75}, second = {10, 20, 100, 10, 100};
  const Selection without = select(first, second);
  const std::pair<float, float> bad[] = {{1, kNaN}, {kNaN, 1},    {0, 0},    {1, 0},    {-1, 2},
                                         {2, 1},    {kInf, kInf}, {kInf, 1}, {1, kInf}, {1, -2}};
  for (const auto& [d1, d2] : bad) {
    std::vector<float> f = first, s = second;
    f.insert(f.begin() + 2, 3, d1);
    s.insert(s.begin() + 2, 3, d2);
    const Selection with = select(f, s);
    EXPECT_EQ(with.mask, (Mask{1, 1, 0, 0, 0, 1, 0, 0})) << d1 << "/" << d2;
    EXPECT_EQ(with.message, without.message) << d1 << "/" << d2;
    EXPECT_EQ(with.score[2], 0.0f) << d1 << "/" << d2;
  }
}

TEST(Nnsr, FallsBackWhereOtsuIsUndefined) {
  // One ratio, or all the same.
  EXPECT_EQ(select({0.8f}, {1}).mask, Mask{0});  // 0.8f is a little more than 0.8
  EXPECT_EQ(select({4}, {5}).mask, Mask{1});
  EXPECT_EQ(select({81}, {100}).mask, Mask{0});
  EXPECT_EQ(select({1, 2, 3}, {2, 4, 6}).mask, (Mask{1, 1, 1}));
  EXPECT_EQ(select({1, 2, 3}, {1, 2, 3}).mask, (Mask{0, 0, 0}));
  EXPECT_TRUE(contains(select({4}, {5}).message, "the threshold is fallback = 0.8"));
  NnsrOptions options;
  options.fallback = 0.4;
  EXPECT_EQ(select({1, 2, 3}, {2, 4, 6}, options).mask, (Mask{0, 0, 0}));
  // The limits are those of Otsu's threshold, not of the fallback.
  options.min_threshold = 0.9;
  EXPECT_EQ(select({1, 2, 3}, {2, 4, 6}, options).mask, (Mask{0, 0, 0}));
  const Selection none = select({1, 1}, {kNaN, kNaN});
  EXPECT_EQ(none.mask, (Mask{0, 0}));
  EXPECT_EQ(none.status, Status::kOk);
}

TEST(Nnsr, LimitsTheThreshold) {
  const std::vector<float> first = {20, 25, 30, 70, 75}, second(5, 100);
  NnsrOptions options;
  options.min_threshold = 0.7;
  EXPECT_EQ(select(first, second, options).mask, (Mask{1, 1, 1, 1, 0}));
  options.min_threshold = 0;
  options.max_threshold = 0.25;
  EXPECT_EQ(select(first, second, options).mask, (Mask{1, 1, 0, 0, 0}));
  options.min_threshold = 0.5;
  EXPECT_EQ(errorOf<std::invalid_argument>([&options] { NnsrSelector selector(options); }),
            "option min_threshold = 0.5 is larger than max_threshold = 0.25");
}

TEST(Nnsr, LowesThresholdIsFixed) {
  Correspondences m;
  for (int i = 0; i < 4; ++i) m.add({float(i), 2}, {3, float(i)});
  m.distance = {1, 79, 81, 99};
  m.second_distance = {100, 100, 100, 100};
  EXPECT_EQ(createSelector("nnsr:lowe")->select(m).mask, (Mask{1, 1, 0, 0}));
}

TEST(Nnsr, NamesTheMissingColumn) {
  Correspondences m;
  m.add({1, 2}, {3, 4});
  const NnsrSelector selector;
  EXPECT_EQ(selector.select(m).status, Status::kUnsupportedInput);
  EXPECT_EQ(selector.select(m).message, "nnsr needs the column distance");
  m.distance = {1};
  EXPECT_EQ(selector.select(m).message, "nnsr needs the column second_distance");
  m.second_distance = {2};
  EXPECT_EQ(selector.select(m).status, Status::kOk);
  EXPECT_EQ(selector.select({}).status, Status::kOk);
}

TEST(Nnsr, FindsTheRightMatches) {
  const Scene scene = homographyScene();
  const Quality q = quality(NnsrSelector().select(scene.matches).mask, scene.inlier);
  EXPECT_EQ(q.precision, 100);
  EXPECT_EQ(q.recall, 100);
}

TEST(Nnsr, CannotBeUsedOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  for (const LabelledPair& pair : adelaidePairs()) {
    const Selection s = NnsrSelector().select(pair.matches);
    EXPECT_EQ(s.status, Status::kUnsupportedInput) << pair.name;
    EXPECT_EQ(s.n_selected, 0u) << pair.name;
  }
}

}  // namespace
}  // namespace corrsel::core
