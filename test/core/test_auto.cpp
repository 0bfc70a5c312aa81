#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "corrsel/selectors/auto.h"
#include "search/significance.h"
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

TEST(Auto, FindsThreePercentOfInliersOnAPlane) {
  SceneOptions options;
  options.n = 2000;
  options.inlier_ratio = 0.03;
  const Scene scene = homographyScene(options);
  const Selection selection = selectWith(scene.matches);
  EXPECT_EQ(selection.status, Status::kOk) << selection.message;
  EXPECT_GT(fMeasure(scene, selection), 0.9);
}

TEST(Auto, TellsHowProbablyEachMatchIsRight) {
  for (const bool rigid : {false, true}) {
    const SceneOptions options{1000, 0.5, 0.5, 1};
    const Scene scene = rigid ? stereoScene(options) : homographyScene(options);
    Selection selection = selectWith(scene.matches);
    ASSERT_EQ(selection.probability.size(), scene.matches.size());
    double right = 0, wrong = 0;
    for (std::size_t i = 0; i < scene.inlier.size(); ++i)
      (scene.inlier[i] != 0 ? right : wrong) += selection.probability[i] / 500;
    EXPECT_GT(right, 0.93);
    EXPECT_LT(wrong, 0.05);
    // Only the right points have noise, and the Sampson distance shares it among four coordinates.
    EXPECT_NEAR(selection.sigma, rigid ? 0.5 / std::sqrt(2.0) : 0.5, 0.08);

    const std::vector<float> own = selection.probability;
    const double sigma = selection.sigma;
    selection.probability.clear();
    selection.sigma = std::numeric_limits<double>::quiet_NaN();
    addProbability(scene.matches, selection);
    EXPECT_EQ(selection.probability, own) << "the definition is that of all selectors";
    EXPECT_EQ(selection.sigma, sigma);
  }
}

TEST(Auto, TakesNoMatchForRightWhereNothingIsFound) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Selection selection = selectWith(noiseScene(500, seed).matches);
    ASSERT_EQ(selection.probability.size(), 500u);
    EXPECT_LT(*std::max_element(selection.probability.begin(), selection.probability.end()), 0.5F);
    EXPECT_LT(std::accumulate(selection.probability.begin(), selection.probability.end(), 0.0), 5);
  }
  Correspondences few = noiseScene(4, 1).matches;
  EXPECT_EQ(selectWith(few).probability, std::vector<float>(4, 0));
  EXPECT_TRUE(std::isnan(selectWith(few).sigma));
  few = Correspondences();
  for (int i = 0; i < 20; ++i) few.add({5, 5}, {7, 7});
  EXPECT_EQ(selectWith(few).probability, std::vector<float>(20, 0));
}

TEST(Auto, IsUncertainWhereAllAreOutliers) {
  int significant = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Selection selection = selectWith(noiseScene(500, seed).matches, {{"hard_search", "20000"}});
    significant += selection.status == Status::kOk ? 1 : 0;
    EXPECT_LT(selection.confidence, 4);
  }
  EXPECT_LE(significant, 1);
}

TEST(Auto, AcceptsEveryModelWithoutALeastConfidence) {
  const Selection selection = selectWith(noiseScene(300, 1).matches, {{"min_confidence", "0"}});
  EXPECT_NE(selection.status, Status::kUncertain);
}

/// A camera moves past a wall that stands askew, and an object in front of it moves by itself. `inlier` is 1
/// for the wall, 2 for the object.
Scene movingObjectScene(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  const cv::Matx33d camera(700, 0, 400, 0, 700, 300, 0, 0, 1), inverse = camera.inv();
  const double angle = 0.05;
  const cv::Matx33d rotation(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                             std::cos(angle));
  const cv::Matx33d object(1.08, -0.15, 0, 0.15, 1.08, -30, 0, 0, 1);
  const cv::Rect2d place(250, 200, 250, 200);  // of the object
  const auto addRight = [&](const cv::Point2d& left, const cv::Point2d& right, std::uint8_t value) {
    const cv::Point2d noisy = right + 0.5 * normalPoint(random);
    if (!cv::Rect2d(0, 0, kSceneWidth, kSceneHeight).contains(noisy)) return;
    addMatch(scene, random, left, noisy, true);
    scene.inlier.back() = value;
  };
  for (int i = 0; i < 600; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    if (place.contains(left)) {
      addRight(left, projected(object, left.x, left.y), 2);
      continue;
    }
    // Depths from 4 to 12, with a fold in the middle.
    const double depth = 4 + 8 * std::abs(left.x - 400) / 400;
    const cv::Vec3d seen =
        camera * (rotation * (depth * (inverse * cv::Vec3d(left.x, left.y, 1))) + cv::Vec3d(-0.6, 0.1, 0.1));
    addRight(left, {seen[0] / seen[2], seen[1] / seen[2]}, 1);
  }
  for (int i = 0; i < 300; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    addMatch(scene, random, left, uniformPoint(random, kSceneWidth, kSceneHeight), false);
  }
  return scene;
}

TEST(Auto, NumbersTheMotions) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Scene scene = movingObjectScene(seed);
    const Selection selection = selectWith(scene.matches);
    EXPECT_EQ(selection.model_kind, ModelKind::kFundamental);
    ASSERT_EQ(selection.group.size(), scene.matches.size()) << selection.message;
    double of_kind[3] = {}, in_group[3] = {};
    for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
      const std::int32_t group = selection.group[i];
      EXPECT_TRUE(group < 0 || selection.mask[i] == 1) << i;
      ++of_kind[scene.inlier[i]];
      in_group[scene.inlier[i]] += group == scene.inlier[i] - 1 ? 1 : 0;
    }
    for (int kind = 0; kind < 3; ++kind)
      EXPECT_GE(in_group[kind], 0.95 * of_kind[kind]) << "kind " << kind << ", seed " << seed;
  }
}

TEST(Auto, TellsWhatKindOfSceneItIs) {
  const auto sceneOf = [](const Correspondences& matches, const OptionMap& options = {}) {
    return toString(selectWith(matches, options).scene);
  };
  EXPECT_EQ(sceneOf(homographyScene().matches), "plane_or_rotation");
  EXPECT_EQ(sceneOf(stereoScene({1000}).matches), "rigid");
  EXPECT_EQ(sceneOf(movingObjectScene(0).matches), "several_motions");
  EXPECT_EQ(sceneOf(noiseScene(500, 1).matches), "nothing");
  EXPECT_EQ(sceneOf(homographyScene().matches, {{"model", "homography"}}), "unknown");
  EXPECT_EQ(sceneOf(stereoScene().matches, {{"model", "fundamental"}}), "unknown");
}

/// Right points of a fifth of the matches are anywhere, the others move by `shift`.
Correspondences shifted(double shift) {
  Random random(3);
  Correspondences matches;
  for (int i = 0; i < 500; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    const cv::Point2d still = left + cv::Point2d(shift, 0) + 0.5 * normalPoint(random);
    matches.add(left, i % 5 == 0 ? uniformPoint(random, kSceneWidth, kSceneHeight) : still);
  }
  return matches;
}

TEST(Auto, IsAtRestWhereTheInliersDoNotMove) {
  const Selection rest = selectWith(shifted(0)), moving = selectWith(shifted(2));
  EXPECT_EQ(rest.scene, SceneKind::kAtRest) << rest.message;
  EXPECT_EQ(moving.scene, SceneKind::kPlaneOrRotation) << moving.message;
  EXPECT_GT(rest.n_selected, 390U);
  EXPECT_GT(moving.n_selected, 390U);
}

TEST(Auto, OneMotionHasNoNumber) {
  EXPECT_TRUE(selectWith(homographyScene().matches).group.empty());
  EXPECT_TRUE(selectWith(stereoScene({1000}).matches).group.empty());
  EXPECT_TRUE(selectWith(movingObjectScene(0).matches, {{"model", "fundamental"}}).group.empty());
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
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(backward.mask[i], forward.mask[rows[i]]) << i;
    ASSERT_EQ(backward.probability[i], forward.probability[rows[i]]) << i;
  }
  EXPECT_EQ(backward.model, forward.model);
  EXPECT_EQ(backward.sigma, forward.sigma);
}

TEST(Auto, DoesNotDependOnTheNumberOfThreads) {
  const Scene scene = homographyScene();
  const Selection one = selectWith(scene.matches), three = selectWith(scene.matches, {{"threads", "3"}});
  EXPECT_EQ(one.mask, three.mask);
  EXPECT_EQ(one.model, three.model);
  EXPECT_EQ(one.probability, three.probability);
  EXPECT_EQ(one.sigma, three.sigma);
}

TEST(Auto, WorksOnCoordinatesAlone) {
  Scene scene = homographyScene();
  scene.matches.distance.clear();
  scene.matches.second_distance.clear();
  scene.matches.left_size = scene.matches.right_size = {};
  EXPECT_GT(fMeasure(scene, selectWith(scene.matches)), 0.97);
}

TEST(Auto, CutsTheHardSearchAtTheTimeLimit) {
  const Correspondences noise = noiseScene(500, 3).matches;
  const int without_hard_search = selectWith(noise, {{"hard_search", "0"}}).iterations;
  const int unlimited = selectWith(noise).iterations;
  EXPECT_GE(unlimited, without_hard_search + 10000);
  TickingClock clock(0.1);
  const Selection selection = selectWith(noise, {{"max_seconds", "40"}});
  EXPECT_EQ(selection.status, Status::kTimeLimit) << selection.message;
  EXPECT_NE(selection.message.find("max_seconds = 40"), std::string::npos) << selection.message;
  EXPECT_EQ(selection.scene, SceneKind::kUnknown) << "a part of the evidence is missing";
  EXPECT_GT(selection.iterations, without_hard_search);
  EXPECT_LT(selection.iterations, unlimited);
}

TEST(Auto, RefusesTooFewMatches) {
  const Correspondences few = homographyScene().matches.subset({0, 1, 2, 3, 4});
  const Selection selection = selectWith(few);
  EXPECT_EQ(selection.status, Status::kTooFew);
  EXPECT_EQ(selection.n_selected, 0U);
  EXPECT_EQ(selectWith({}).status, Status::kTooFew);
}

TEST(Auto, EqualPointsAreNotSignificant) {
  Correspondences equal;
  for (int i = 0; i < 50; ++i) equal.add({10, 10}, {20, 20});
  EXPECT_NE(selectWith(equal).status, Status::kOk);
}

}  // namespace
}  // namespace corrsel::core
