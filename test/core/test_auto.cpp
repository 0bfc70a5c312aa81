#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "consensus/significance.h"
#include "corrsel/selectors/auto.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

Selection selectWith(const Correspondences& matches, const OptionMap& options = {}) {
  AutoSelector selector;
  selector.configure(options);
  return selector.select(matches);
}

double fMeasure(const Scene& scene, const Selection& selection) {
  double both = 0, right = 0, selected = 0;
  for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
    both += scene.inlier[i] != 0 && selection.mask[i] != 0 ? 1 : 0;
    right += scene.inlier[i];
    selected += selection.mask[i];
  }
  return both == 0 ? 0 : 2 * both / (right + selected);
}

Scene noiseScene(std::size_t n, std::uint64_t seed) {
  SceneOptions options;
  options.n = n;
  options.inlier_ratio = 0;
  options.seed = seed;
  return homographyScene(options);
}

TEST(Auto, SelectsAPlane) {
  const Scene scene = homographyScene();
  const Selection selection = selectWith(scene.matches);
  EXPECT_EQ(selection.status, Status::kOk) << selection.message;
  EXPECT_EQ(selection.model_kind, ModelKind::kHomography);
  EXPECT_GT(fMeasure(scene, selection), 0.97);
  EXPECT_GT(selection.confidence, 100);
}

TEST(Auto, SelectsARigidSceneWithDepth) {
  SceneOptions options;
  options.n = 1000;
  const Scene scene = stereoScene(options);
  const Selection selection = selectWith(scene.matches);
  EXPECT_EQ(selection.status, Status::kOk) << selection.message;
  EXPECT_EQ(selection.model_kind, ModelKind::kFundamental);
  EXPECT_GT(fMeasure(scene, selection), 0.9);
}

TEST(Auto, FindsThreePercentOfRightMatchesOnAPlane) {
  SceneOptions options;
  options.n = 2000;
  options.inlier_ratio = 0.03;
  const Scene scene = homographyScene(options);
  const Selection selection = selectWith(scene.matches);
  EXPECT_EQ(selection.status, Status::kOk) << selection.message;
  EXPECT_GT(fMeasure(scene, selection), 0.9);
}

TEST(Auto, IsUncertainWhereNothingIsRight) {
  int believed = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Selection selection = selectWith(noiseScene(500, seed).matches, {{"hard_search", "20000"}});
    believed += selection.status == Status::kOk ? 1 : 0;
    EXPECT_LT(selection.confidence, 4);
  }
  EXPECT_LE(believed, 1);
}

TEST(Auto, AcceptsEveryModelWithoutALeastConfidence) {
  const Selection selection = selectWith(noiseScene(300, 1).matches, {{"min_confidence", "0"}});
  EXPECT_NE(selection.status, Status::kUncertain);
}

TEST(Auto, PresetsRestrictTheModel) {
  const Scene plane = homographyScene(), space = stereoScene();
  EXPECT_EQ(selectWith(plane.matches, {{"model", "fundamental"}}).model_kind, ModelKind::kFundamental);
  EXPECT_EQ(selectWith(space.matches, {{"model", "homography"}}).model_kind, ModelKind::kHomography);
  const Presets presets = AutoSelector().presets();
  for (const auto& [name, options] : presets) EXPECT_NO_THROW(selectWith(plane.matches, options)) << name;
}

TEST(Auto, DoesNotDependOnTheOrderOfTheInput) {
  const Scene scene = stereoScene();
  const Selection forward = selectWith(scene.matches);
  std::vector<std::uint32_t> rows(scene.matches.size());
  std::iota(rows.rbegin(), rows.rend(), 0U);
  const Selection backward = selectWith(scene.matches.subset(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(backward.mask[i], forward.mask[rows[i]]) << i;
  EXPECT_EQ(backward.model, forward.model);
}

TEST(Auto, DoesNotDependOnTheNumberOfThreads) {
  const Scene scene = homographyScene();
  const Selection one = selectWith(scene.matches), three = selectWith(scene.matches, {{"threads", "3"}});
  EXPECT_EQ(one.mask, three.mask);
  EXPECT_EQ(one.model, three.model);
}

TEST(Auto, WorksOnCoordinatesAlone) {
  Scene scene = homographyScene();
  scene.matches.distance.clear();
  scene.matches.second_distance.clear();
  scene.matches.left_size = scene.matches.right_size = {};
  EXPECT_GT(fMeasure(scene, selectWith(scene.matches)), 0.97);
}

TEST(Auto, CutsTheHardSearchAtTheTimeLimit) {
  TickingClock clock(0.1);
  const Selection selection = selectWith(noiseScene(500, 3).matches, {{"max_seconds", "5"}});
  EXPECT_EQ(selection.status, Status::kTimeLimit) << selection.message;
  EXPECT_NE(selection.message.find("max_seconds = 5"), std::string::npos) << selection.message;
  EXPECT_LT(selection.iterations, 400000);
}

TEST(Auto, RefusesTooFewMatches) {
  const Correspondences few = homographyScene().matches.subset({0, 1, 2, 3, 4});
  const Selection selection = selectWith(few);
  EXPECT_EQ(selection.status, Status::kTooFew);
  EXPECT_EQ(selection.n_selected, 0U);
  EXPECT_EQ(selectWith({}).status, Status::kTooFew);
}

TEST(Auto, EqualPointsAreNotBelieved) {
  Correspondences equal;
  for (int i = 0; i < 50; ++i) equal.add({10, 10}, {20, 20});
  EXPECT_NE(selectWith(equal).status, Status::kOk);
}

}  // namespace
}  // namespace corrsel::core
