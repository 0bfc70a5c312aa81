#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "geometry/frame_map.h"
#include "search/frame_hypotheses.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

AffineFrame frame(float a11, float a12, float a21, float a22) { return {a11, a12, 0, a21, a22, 0}; }

TEST(FrameMap, TakesTheLeftFrameToTheRightOne) {
  const auto map = frameMap(frame(2, 0, 0, 4), frame(2, 4, -6, 4));
  ASSERT_TRUE(map);
  EXPECT_EQ(*map, (LinearMap{1, 1, -3, 1}));
}

TEST(FrameMap, SetsFramesAsideThatCannotBeUsed) {
  const AffineFrame unit = frame(1, 0, 0, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const AffineFrame& bad :
       {frame(0, 0, 0, 0), frame(1, 1, 1, 1), frame(11, 0, 0, 1), frame(nan, 0, 0, 1)}) {
    EXPECT_FALSE(frameMap(unit, bad));
    EXPECT_FALSE(frameMap(bad, unit));
  }
  EXPECT_FALSE(frameMap(unit, frame(1001, 0, 0, 1001)));
  EXPECT_TRUE(frameMap(unit, frame(999, 0, 0, 999)));
}

std::vector<std::uint32_t> allRows(const Correspondences& matches) {
  std::vector<std::uint32_t> rows(matches.size());
  std::iota(rows.begin(), rows.end(), 0U);
  return rows;
}

Scene sceneWithFrames(std::size_t n, double inlier_ratio, std::uint64_t seed) {
  Scene scene = homographyScene({n, inlier_ratio, 1.0, seed});
  addFrames(scene, 0.1);
  return scene;
}

TEST(FrameHypotheses, FirstMapIsNearThePlane) {
  const Scene scene = sceneWithFrames(500, 0.1, 1);
  FrameHypotheses hypotheses;
  hypotheses.assign(scene.matches, allRows(scene.matches), nullptr);
  ASSERT_TRUE(hypotheses.next());
  ASSERT_NE(hypotheses.map(), nullptr);
  const cv::Point2d centre(kSceneWidth / 2.0, kSceneHeight / 2.0);
  const cv::Point2d error =
      projected(*hypotheses.map(), centre.x, centre.y) - projected(scene.model, centre.x, centre.y);
  EXPECT_LT(cv::norm(error), 10);
}

TEST(FrameHypotheses, PassesOverMatchesThatAnEarlierMapExplains) {
  const Scene scene = sceneWithFrames(500, 1.0, 2);
  FrameHypotheses hypotheses;
  hypotheses.assign(scene.matches, allRows(scene.matches), nullptr);
  std::size_t tried = 0;
  while (hypotheses.next()) ++tried;
  EXPECT_GE(tried, 1u);
  EXPECT_LT(tried, 100u);
}

TEST(FrameHypotheses, NothingIsLeftWithoutUsableFrames) {
  Scene scene = sceneWithFrames(100, 1.0, 3);
  std::fill(scene.matches.left_frame.begin(), scene.matches.left_frame.end(), AffineFrame{});
  FrameHypotheses hypotheses;
  hypotheses.assign(scene.matches, allRows(scene.matches), nullptr);
  EXPECT_FALSE(hypotheses.next());
  EXPECT_EQ(hypotheses.map(), nullptr);
  hypotheses.assign({}, {}, nullptr);
  EXPECT_FALSE(hypotheses.next());
}

TEST(FrameHypotheses, EqualPointsAndUnknownSizesAreNoError) {
  Correspondences equal;
  for (int i = 0; i < 20; ++i) equal.add({10, 10}, {20, 20});
  equal.left_frame.assign(20, frame(1, 0, 0, 1));
  equal.right_frame = equal.left_frame;
  FrameHypotheses hypotheses;
  hypotheses.assign(equal, allRows(equal), nullptr);
  while (hypotheses.next()) continue;
}

/// Samples of four would need 29 million draws for 2 % of inliers.
TEST(SamplerFrames, FindsAPlaneWithTwoPercentOfRightMatches) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene = sceneWithFrames(3000, 0.02, seed);
    const Selection selection = createSelector("usac", {{"sampler", "frames"}})->select(scene.matches);
    found += quality(selection.mask, scene.inlier).f > 80 ? 1 : 0;
  }
  EXPECT_GE(found, 19);
}

TEST(SamplerFrames, NeedsFramesAndAHomography) {
  const Scene bare = homographyScene(), scene = sceneWithFrames(500, 0.5, 4);
  for (const char* const name : {"ransac", "usac", "acransac"}) {
    SCOPED_TRACE(name);
    const Selection without = createSelector(name, {{"sampler", "frames"}})->select(bare.matches);
    EXPECT_EQ(without.status, Status::kUnsupportedInput);
    EXPECT_TRUE(contains(without.message, "needs the local affine frames")) << without.message;
    const Selection line =
        createSelector(name, {{"sampler", "frames"}, {"model", "fundamental"}})->select(scene.matches);
    EXPECT_EQ(line.status, Status::kUnsupportedInput);
    EXPECT_TRUE(contains(line.message, "homographies only")) << line.message;
    const Selection with = createSelector(name, {{"sampler", "frames"}})->select(scene.matches);
    EXPECT_EQ(with.status, Status::kOk) << with.message;
    EXPECT_GT(quality(with.mask, scene.inlier).f, 98);
  }
}

TEST(SamplerFrames, StopsAtTheTimeLimit) {
  const Scene scene = sceneWithFrames(1000, 0, 5);
  const TickingClock clock(1);
  const Selection found =
      createSelector("usac", {{"sampler", "frames"}, {"max_seconds", "5.5"}})->select(scene.matches);
  EXPECT_EQ(found.status, Status::kTimeLimit) << found.message;
  EXPECT_LE(clock.looks(), 8);
}

TEST(SamplerFrames, IsTheSameWithEveryKernelLevelAndOrder) {
  const LevelGuard guard;
  const Scene scene = sceneWithFrames(700, 0.3, 6);
  const auto selector = createSelector("usac", {{"sampler", "frames"}});
  const Selection expected = selector->select(scene.matches);
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    EXPECT_EQ(selector->select(scene.matches).model, expected.model);
  }
  std::vector<std::uint32_t> rows = allRows(scene.matches);
  std::reverse(rows.begin(), rows.end());
  EXPECT_EQ(selector->select(scene.matches.subset(rows)).model, expected.model);
}

}  // namespace
}  // namespace corrsel::core
