#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "corrsel/selectors/selector.h"
#include "posterior/match_probability.h"
#include "posterior/posterior.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// What a selector returns that knows the model.
Selection answerOf(const Scene& scene, bool model = true) {
  Selection selection;
  selection.mask = scene.inlier;
  if (model) selection.model = scene.model;
  selection.confidence = 100;
  return selection;
}

Selection rated(const Correspondences& matches, Selection selection) {
  computePosterior(matches, selection, Workspace::ofThread());
  EXPECT_EQ(selection.probability.size(), matches.size());
  for (const float p : selection.probability) EXPECT_TRUE(p >= 0 && p <= 1) << p;
  return selection;
}

Selection rated(const Scene& scene, ModelKind kind) {
  Selection selection = answerOf(scene, kind != ModelKind::kNone);
  selection.model_kind = kind;
  return rated(scene.matches, selection);
}

struct Share {
  double n = 0, probability = 0, right = 0;
};

TEST(MatchProbability, IsTheShareOfRightMatchesInGeneratedScenes) {
  for (const ModelKind kind : {ModelKind::kHomography, ModelKind::kFundamental}) {
    for (const double ratio : {0.1, 0.3, 0.7}) {
      Share low, high, all;
      for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const SceneOptions options{1000, ratio, 1.0, seed};
        Scene scene = kind == ModelKind::kHomography ? homographyScene(options) : stereoScene(options);
        if (kind == ModelKind::kHomography) addFrames(scene);
        const Selection selection = rated(scene, kind);
        for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
          const double p = selection.probability[i];
          for (Share* share : {&all, p < 0.1 ? &low : p > 0.9 ? &high : nullptr}) {
            if (share == nullptr) continue;
            ++share->n;
            share->probability += p;
            share->right += scene.inlier[i];
          }
        }
      }
      // The depths of stereoScene() jump from point to point, so that its inliers have no local support.
      const bool supported = kind == ModelKind::kHomography;
      EXPECT_NEAR(all.probability / all.n, ratio, supported ? 0.02 : 0.08) << toString(kind);
      EXPECT_LT(low.right / low.n, 0.02) << toString(kind);
      EXPECT_GT(high.right / high.n, 0.97) << toString(kind);
      EXPECT_GT(low.n + high.n, (supported ? 0.95 : 0.65) * all.n) << toString(kind);
    }
  }
}

TEST(MatchProbability, FallsWithTheResidualAndTheRatioAndTheDoubt) {
  Scene scene = homographyScene({600, 0.5, 0.5, 2});
  const std::size_t row = 0;
  const float right_x = scene.matches.right_x[row];
  double last = 1;
  for (const float error : {0.0F, 2.0F, 4.0F, 6.0F, 12.0F}) {
    scene.matches.right_x[row] = right_x + error;
    Selection selection = answerOf(scene);
    selection.model_kind = ModelKind::kHomography;
    selection.mask[row] = error < 5 ? 1 : 0;
    const double p = rated(scene.matches, selection).probability[row];
    EXPECT_LT(p, last) << error;
    last = p;
  }
  EXPECT_LT(last, 0.1);

  scene.matches.right_x[row] = right_x + 3;
  const double good = rated(scene, ModelKind::kHomography).probability[row];
  scene.matches.second_distance[row] = scene.matches.distance[row] * 1.01F;
  EXPECT_LT(rated(scene, ModelKind::kHomography).probability[row], good);

  Selection doubtful = answerOf(scene);
  doubtful.model_kind = ModelKind::kHomography;
  doubtful.confidence = 0;
  const Selection doubted = rated(scene.matches, doubtful);
  EXPECT_LT(*std::max_element(doubted.probability.begin(), doubted.probability.end()), 0.5);
}

TEST(MatchProbability, CountsTheSupportWithoutAModel) {
  Scene scene = homographyScene({600, 0.5, 0.5, 2});
  addFrames(scene);
  const Selection selection = rated(scene, ModelKind::kNone);
  EXPECT_TRUE(std::isnan(selection.sigma));
  double right = 0, wrong = 0;
  for (std::size_t i = 0; i < scene.inlier.size(); ++i)
    (scene.inlier[i] != 0 ? right : wrong) += selection.probability[i] / 300;
  EXPECT_GT(right, 0.9);
  EXPECT_LT(wrong, 0.1);
}

TEST(MatchProbability, IsZeroWhereNothingIsSelected) {
  const Scene scene = homographyScene({200, 0.5, 0.5, 2});
  Selection selection = answerOf(scene);
  selection.model_kind = ModelKind::kHomography;
  selection.mask.assign(200, 0);
  selection = rated(scene.matches, selection);
  EXPECT_EQ(selection.probability, std::vector<float>(200, 0));
  EXPECT_TRUE(std::isnan(selection.sigma));
}

TEST(MatchProbability, DoesNotDependOnTheOrder) {
  for (const ModelKind kind : {ModelKind::kHomography, ModelKind::kFundamental, ModelKind::kNone}) {
    const SceneOptions options{700, 0.4, 1.0, 5};
    const Scene scene = kind == ModelKind::kFundamental ? stereoScene(options) : homographyScene(options);
    const Selection selection = rated(scene, kind);
    std::vector<std::uint32_t> rows(700);
    for (std::uint32_t i = 0; i < rows.size(); ++i) rows[i] = (i * 311 + 17) % 700;
    Scene other = scene;
    other.matches = scene.matches.subset(rows);
    for (std::size_t i = 0; i < rows.size(); ++i) other.inlier[i] = scene.inlier[rows[i]];
    const Selection changed = rated(other, kind);
    for (std::size_t i = 0; i < rows.size(); ++i)
      ASSERT_EQ(changed.probability[i], selection.probability[rows[i]]) << toString(kind);
    EXPECT_EQ(std::isnan(changed.sigma), kind == ModelKind::kNone);
    EXPECT_TRUE(kind == ModelKind::kNone || changed.sigma == selection.sigma);
  }
}

TEST(MatchProbability, AnswersDegenerateInput) {
  Selection selection;
  selection.confidence = 0;
  EXPECT_TRUE(rated(Correspondences(), selection).probability.empty());
  for (const ModelKind kind : {ModelKind::kHomography, ModelKind::kFundamental, ModelKind::kNone}) {
    selection.model_kind = kind;
    selection.model =
        kind == ModelKind::kFundamental ? cv::Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 0) : cv::Matx33d::eye();
    Correspondences equal, four;
    for (int i = 0; i < 30; ++i) equal.add({3, 4}, {3, 4});
    for (int i = 0; i < 4; ++i) four.add({100.0F * i, 10.0F * i * i}, {100.0F * i, 10.0F * i * i});
    for (const Correspondences& matches : {equal, four, four.subset({1})}) {
      selection.mask.assign(matches.size(), 1);
      const Selection found = rated(matches, selection);
      EXPECT_EQ(std::isnan(found.sigma), kind == ModelKind::kNone || matches.size() <= 4) << toString(kind);
      EXPECT_LT(found.probability[0], 0.5) << "the confidence is 0";
    }
    Correspondences strange = four;
    strange.distance = {0, 1, -1, std::numeric_limits<float>::quiet_NaN()};
    strange.second_distance = {0, 0, 1, 1};
    selection.mask.assign(4, 1);
    rated(strange, selection);
  }
}

}  // namespace
}  // namespace corrsel::core
