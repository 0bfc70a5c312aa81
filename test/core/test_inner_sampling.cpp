#include <gtest/gtest.h>

#include "search/inner_sampling.h"
#include "search/model.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kThreshold = 1.5;  // px

/// A hypothesis from five inliers and two outliers that agrees with at least 16 of 500 matches, as one in
/// four of them does.
Candidate impureHypothesis(const Scene& scene, const NormalizedMatches& matches, const Verifier& verifier,
                           Random& random) {
  const Model& model = modelOf(ModelKind::kFundamental);
  std::vector<std::uint32_t> inliers, outliers;
  for (std::uint32_t i = 0; i < scene.inlier.size(); ++i)
    (scene.inlier[i] != 0 ? inliers : outliers).push_back(i);
  for (int k = 0; k < 100000; ++k) {
    std::uint32_t sample[7], places[7];
    random.sample(static_cast<std::uint32_t>(inliers.size()), 5, places);
    random.sample(static_cast<std::uint32_t>(outliers.size()), 2, places + 5);
    for (int i = 0; i < 7; ++i) sample[i] = (i < 5 ? inliers : outliers)[places[i]];
    cv::Matx33d models[Model::kMaxModels];
    const int count = model.solve(matches, sample, models);
    for (int i = 0; i < count; ++i) {
      Candidate candidate;
      verifier.improve(models[i], candidate);
      if (candidate.inliers >= 16) return candidate;
    }
  }
  return {};
}

TEST(InnerSampling, MakesRightModelsOfSamplesWithOutliers) {
  const Model& model = modelOf(ModelKind::kFundamental);
  Random random(7);
  int found = 0;
  constexpr int kTrials = 40;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    const Scene scene = stereoScene({500, 0.2, 0.6, seed});
    const NormalizedMatches matches = normalizeMatches(scene.matches);
    const Verifier verifier(matches, model.traits.residual, kThreshold * matches.scale, true);
    const Candidate start = impureHypothesis(scene, matches, verifier, random);
    ASSERT_TRUE(start.exists());
    InnerSampling inner;
    inner.start(model, verifier, seed);
    inner.offer(start);
    Candidate best = start;
    inner.improve(best);
    EXPECT_LE(best.cost, start.cost);
    found += best.inliers > 60 ? 1 : 0;
  }
  // Least squares alone improve hardly any of them.
  EXPECT_GE(found, kTrials / 8);
}

TEST(InnerSampling, TakesTheBestHypothesisOfEachRun) {
  const Scene scene = homographyScene({500, 0.5, 0.5, 4});
  const NormalizedMatches matches = normalizeMatches(scene.matches);
  const Model& model = modelOf(ModelKind::kHomography);
  const Verifier verifier(matches, model.traits.residual, 6 * matches.scale, true);
  InnerSampling inner;
  inner.start(model, verifier, 0);
  int iterations = 1;
  while (!inner.endsRun() && iterations < 1000) ++iterations;
  EXPECT_EQ(iterations, 1000);  // a run without a hypothesis gives nothing to sample
  Candidate start;
  verifier.improve(matches.homographyFromPixels(scene.model), start);
  inner.offer(start);
  EXPECT_EQ(inner.limit(), start.cost);
  int runs = 0;
  for (int k = 0; k < 100; ++k) runs += inner.endsRun() ? 1 : 0;
  EXPECT_EQ(runs, 1);
  Candidate best;
  EXPECT_TRUE(inner.improve(best));
  EXPECT_LE(best.cost, start.cost);
  EXPECT_EQ(inner.limit(), Candidate().cost);  // the next run begins
  EXPECT_FALSE(inner.endsRun());
  // Nothing is better than a model that costs nothing.
  best.cost = 0;
  inner.offer(start);
  EXPECT_FALSE(inner.improve(best));
}

}  // namespace
}  // namespace corrsel::core
