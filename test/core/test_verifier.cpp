#include <gtest/gtest.h>

#include "geometry/homography.h"
#include "search/homography_model.h"
#include "search/local_optimization.h"
#include "search/verifier.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

/// Matches of a plane in random order, and the true model, normalised.
struct Plane {
  explicit Plane(std::size_t n, double inlier_ratio, double noise, std::uint64_t seed = 1) {
    const Scene scene = homographyScene({n, inlier_ratio, noise, seed});
    normalizeMatches(scene.matches, permutation(n, 3), matches);
    truth = matches.right * scene.model * matches.left.inv();
    truth = truth * (1 / cv::norm(truth));
  }
  NormalizedMatches matches;
  cv::Matx33d truth;
};

TEST(Verifier, ScoresAreMsacOrTheNumberOfOutliers) {
  const Plane plane(1000, 0.4, 0.5);
  const Verifier msac(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, true);
  const Verifier count(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, false);
  const ModelScore a = msac.score(plane.truth, kNoLimit), b = count.score(plane.truth, kNoLimit);
  EXPECT_EQ(a.inliers, 400u);
  EXPECT_EQ(b.inliers, 400u);
  EXPECT_EQ(b.cost, 600 * ScoreRule::kOutlierCost);
  // Noise of 0.5 px in both coordinates against 3 px: 0.5 / 9 of an outlier's cost each.
  EXPECT_NEAR(double(a.cost) / ScoreRule::kOutlierCost, 600 + 400 * 0.5 / 9, 4);
}

TEST(Verifier, GivesUpAtTheLimit) {
  const Plane plane(1000, 0.4, 0.5);
  const Verifier verifier(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, true);
  const std::int64_t cost = verifier.score(plane.truth, kNoLimit).cost;
  EXPECT_TRUE(verifier.score(plane.truth, cost).rejected);
  EXPECT_FALSE(verifier.score(plane.truth, cost + 1).rejected);
}

TEST(Verifier, BailsOutOfAHopelessModelEarlyAndNeverOfABetterOne) {
  const Plane plane(5000, 0.5, 0.5);
  const Verifier verifier(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, true);
  const std::int64_t best = verifier.score(plane.truth, kNoLimit).cost;
  cv::Matx33d wrong = plane.truth;
  wrong(0, 2) += 0.5;
  const ModelScore hopeless = verifier.score(wrong, best);
  EXPECT_TRUE(hopeless.rejected);
  EXPECT_LE(hopeless.seen, 256u);
  EXPECT_FALSE(verifier.score(plane.truth, best + best / 1000).rejected);
}

TEST(Verifier, TestGoesOnWhereTheLastOneEnded) {
  const Plane plane(3000, 0.5, 0.5);
  Verifier verifier(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, true);
  const Sprt sprt({0.2, 0.01, 500, 1});
  cv::Matx33d wrong = plane.truth;
  wrong(0, 2) += 0.5;
  // From wherever they start, a bad model is rejected soon and the good one is scored in full.
  const std::int64_t cost = verifier.score(plane.truth, kNoLimit).cost;
  for (int i = 0; i < 300; ++i) {
    const ModelScore rejected = verifier.test(wrong, kNoLimit, sprt);
    EXPECT_TRUE(rejected.rejected_by_sprt);
    EXPECT_LT(rejected.seen, 200u);
    if (i % 50 == 0) {
      const ModelScore kept = verifier.test(plane.truth, kNoLimit, sprt);
      EXPECT_FALSE(kept.rejected);
      EXPECT_EQ(kept.cost, cost);
      EXPECT_EQ(kept.seen, 3000u);
    }
  }
}

TEST(LocalOptimization, TakesAMinimalModelToTheOptimum) {
  double minimal = 0, optimized = 0, truth = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Plane plane(600, 0.5, 1.0, seed);
    const Verifier verifier(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, true);
    const HomographyModel model(Residual::kTransfer);
    Candidate best;
    Random random(seed);
    // The best of a few models, as in a search.
    for (int i = 0; i < 300; ++i) {
      std::uint32_t sample[4];
      cv::Matx33d h;
      random.sample(600, 4, sample);
      if (model.isValidSample(plane.matches, sample) && homographyFromFour(plane.matches, sample, h))
        verifier.improve(h, best);
    }
    const Candidate before = best;
    optimizeLocally(model, verifier, best);
    EXPECT_LE(best.cost, before.cost);
    minimal += double(before.inliers);
    optimized += double(best.inliers);
    truth += double(verifier.score(plane.truth, kNoLimit).inliers);
  }
  EXPECT_GT(optimized, 0.99 * truth);
  EXPECT_LT(minimal, 0.95 * truth);
}

TEST(LocalOptimization, NeverReturnsAWorseModel) {
  const Plane plane(200, 0.1, 1.0);
  const Verifier verifier(plane.matches, Residual::kTransfer, 3 * plane.matches.scale, true);
  const HomographyModel model(Residual::kTransfer);
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    std::uint32_t sample[4];
    Candidate candidate;
    cv::Matx33d h;
    random.sample(200, 4, sample);
    if (!homographyFromFour(plane.matches, sample, h)) continue;
    verifier.improve(h, candidate);
    const std::int64_t before = candidate.cost;
    optimizeLocally(model, verifier, candidate);
    EXPECT_LE(candidate.cost, before);
    const ModelScore again = verifier.score(candidate.model, kNoLimit);
    EXPECT_EQ(again.cost, candidate.cost);
    EXPECT_EQ(again.inliers, candidate.inliers);
  }
}

}  // namespace
}  // namespace corrsel::core
