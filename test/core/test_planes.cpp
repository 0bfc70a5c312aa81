#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "corrsel/selectors/planes.h"
#include "test_support.h"
#include "two_planes.h"

namespace corrsel::core {
namespace {

using namespace testing;

Selection selectWith(const Correspondences& matches, const OptionMap& options = {}) {
  PlanesSelector selector;
  selector.configure(options);
  return selector.select(matches);
}

TEST(Planes, FindsTwoPlanesAndTheirMembers) {
  int two = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene = twoPlanes(seed);
    const Selection found = selectWith(scene.matches);
    ASSERT_EQ(found.group.size(), scene.matches.size());
    const std::set<std::int32_t> numbers(found.group.begin(), found.group.end());
    two += numbers == std::set<std::int32_t>{-1, 0, 1} ? 1 : 0;
    std::vector<std::uint8_t> right(scene.inlier);
    for (std::uint8_t& value : right) value = value > 0 ? 1 : 0;
    const Quality q = quality(found.mask, right);
    EXPECT_GE(q.precision, 97) << seed;
    EXPECT_GE(q.recall, 98) << seed;
    // The members of a group lie on one plane.
    std::size_t mixed = 0;
    for (std::size_t i = 0; i < 200; ++i) {
      mixed += found.group[i] != found.group[0] ? 1 : 0;
      mixed += found.group[200 + i] != found.group[200] ? 1 : 0;
    }
    EXPECT_LE(mixed, 16u) << seed;
  }
  EXPECT_GE(two, 19);
}

TEST(Planes, OnlySelectedMatchesHaveAGroup) {
  const Scene scene = twoPlanes(3);
  const Selection found = selectWith(scene.matches);
  for (std::size_t i = 0; i < found.mask.size(); ++i) EXPECT_EQ(found.mask[i] != 0, found.group[i] >= 0) << i;
}

TEST(Planes, PresetFirstEndsAfterTheFirstPlane) {
  const Scene scene = twoPlanes(1);
  const Selection one = createSelector("planes:first")->select(scene.matches);
  EXPECT_EQ(one.model_kind, ModelKind::kHomography);
  EXPECT_EQ(one.message, "1 plane");
  EXPECT_EQ(*std::max_element(one.group.begin(), one.group.end()), 0);
  EXPECT_EQ(one.model, selectWith(scene.matches).model);
}

TEST(Planes, UnusableRowsHaveNoGroup) {
  Scene scene = twoPlanes(2);
  scene.matches.left_x[5] = std::numeric_limits<float>::quiet_NaN();
  const Selection found = selectWith(scene.matches);
  ASSERT_EQ(found.group.size(), scene.matches.size());
  EXPECT_EQ(found.group[5], -1);
  EXPECT_GE(found.group[6], 0);
}

TEST(Planes, UsesFramesWhereThereAreAny) {
  Scene scene = homographyScene({2000, 0.03, 1.0, 4});
  EXPECT_EQ(selectWith(scene.matches, {{"sampler", "uniform"}}).status, Status::kNoModel);
  addFrames(scene);
  const Selection found = selectWith(scene.matches);
  EXPECT_EQ(found.status, Status::kOk) << found.message;
  EXPECT_GT(quality(found.mask, scene.inlier).f, 80);
  EXPECT_EQ(selectWith(scene.matches, {{"sampler", "uniform"}, {"frames", "false"}}).status,
            Status::kNoModel);
}

TEST(Planes, OutliersHaveNoPlane) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Selection selection = selectWith(homographyScene({500, 0.0, 0.5, seed}).matches);
    found += selection.status == Status::kNoModel ? 0 : 1;
    if (selection.status == Status::kNoModel) {
      EXPECT_EQ(selection.n_selected, 0u);
      EXPECT_TRUE(selection.group.empty());
    }
  }
  EXPECT_LE(found, 1);
}

TEST(Planes, ReportsDegenerateInput) {
  EXPECT_EQ(selectWith({}).status, Status::kTooFew);
  EXPECT_EQ(selectWith(homographyScene().matches.subset({0, 1, 2})).status, Status::kTooFew);
  EXPECT_EQ(selectWith(homographyScene({4, 1.0, 0.0, 1}).matches).status, Status::kNoModel);
  Correspondences equal, line;
  for (int i = 0; i < 50; ++i) {
    const auto x = static_cast<float>(i);
    equal.add({10, 10}, {20, 20});
    line.add({x, 2 * x}, {x, 2 * x});
  }
  for (const Correspondences& matches : {equal, line}) {
    const Selection found = selectWith(matches);
    EXPECT_NE(found.status, Status::kOk) << found.message;
    EXPECT_EQ(found.n_selected, 0u);
  }
}

TEST(Planes, StopsAtTheTimeLimitWithThePlanesSoFar) {
  const Scene scene = homographyScene({3000, 0.0, 0.5, 5});
  const TickingClock clock(1);
  const Selection found = selectWith(scene.matches, {{"max_seconds", "2.5"}});
  EXPECT_EQ(found.status, Status::kTimeLimit) << found.message;
  EXPECT_TRUE(contains(found.message, "max_seconds = 2.5")) << found.message;
  EXPECT_LE(clock.looks(), 6);
}

TEST(Planes, ReachesItsFOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality means = adelaideMeans("planes");
  EXPECT_GE(means.f, 97.3);
  EXPECT_GE(means.precision, 98.8);
}

}  // namespace
}  // namespace corrsel::core
