#include <gtest/gtest.h>

#include "search/significance.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Matches of which the first `agreeing` (at most 30) follow the identity with the given error, far from each
/// other. The others end together in a corner where no match is predicted, so that the density of right
/// points is nowhere above the uniform one where it counts.
Correspondences identityMatches(std::size_t n, std::size_t agreeing, float error) {
  Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  for (std::size_t i = 0; i < agreeing; ++i) {
    const auto x = static_cast<float>(20 + 55 * (i % 6)), y = static_cast<float>(20 + 55 * (i / 6));
    matches.add({x, y}, {x + error, y});
  }
  for (std::size_t i = agreeing; i < n; ++i)
    matches.add({static_cast<float>(20 + 12 * (i % 48)), static_cast<float>(300 + 4 * (i / 48))},
                {static_cast<float>(610 + i % 29), static_cast<float>(450 + i / 29 % 29)});
  return matches;
}

Significance ofIdentity(const Correspondences& matches, std::uint64_t hypotheses = 0) {
  SignificanceTest test;
  test.assign(matches);
  return test.homography(cv::Matx33d::eye(), hypotheses);
}

/// The tail by summing all terms.
double exactLog10Tail(int n, int k, double p) {
  double term = k * std::log(p) + (n - k) * std::log1p(-p);
  for (int i = 1; i <= k; ++i) term += std::log(double(n - k + i) / i);
  double factor = 1, sum = 0;
  for (int j = k; j <= n; ++j) {
    sum += factor;
    factor *= (n - j) * p / ((j + 1) * (1 - p));
  }
  return (term + std::log(sum)) / std::log(10.0);
}

TEST(Log10BinomialTail, BoundsTheSumOfTheTerms) {
  for (const double p : {1e-6, 1e-4, 0.003, 0.05, 0.3}) {
    for (const int n : {5, 100, 2000}) {
      for (int k = int(2 * n * p) + 2; k <= n; k = k * 3 / 2) {
        const double exact = exactLog10Tail(n, k, p), bound = log10BinomialTail(n, k, p);
        EXPECT_GE(bound, exact - 1e-9) << n << " " << k << " " << p;
        EXPECT_LE(bound, exact + 0.15) << n << " " << k << " " << p;
      }
    }
  }
  EXPECT_EQ(log10BinomialTail(100, 0, 0.1), 0);
  EXPECT_EQ(log10BinomialTail(100, 5, 0.1), 0);
  EXPECT_EQ(log10BinomialTail(100, 5, 1), 0);
  EXPECT_EQ(log10BinomialTail(100, 5, 0), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(log10BinomialTail(4, 5, 0.1), -std::numeric_limits<double>::infinity());
}

TEST(SignificanceTest, GoldenNumbersOfAHomography) {
  EXPECT_NEAR(ofIdentity(identityMatches(100, 30, 0.99F)).confidence, 101.53, 0.01);
  // 150 of 300 matches with errors of 2 px
  EXPECT_NEAR(std::log10(8e4) + log10BinomialTail(296, 146, CV_PI * 4 / 307200), -548.02, 0.01);
  const Significance few = ofIdentity(identityMatches(1000, 12, 2.99F));
  EXPECT_NEAR(few.confidence, 8.05, 0.02);
  EXPECT_EQ(few.threshold, 3);
  EXPECT_EQ(few.agreements, 12u);
}

TEST(SignificanceTest, IsNearZeroButOrderedWhereChanceExplainsTheAgreement) {
  double last = 0;
  for (const std::size_t agreeing : {7, 8, 9}) {
    const double confidence = ofIdentity(identityMatches(1000, agreeing, 2.99F)).confidence;
    EXPECT_GT(confidence, last);
    last = confidence;
  }
  EXPECT_LT(ofIdentity(identityMatches(1000, 7, 2.99F)).confidence, 0.1);
  EXPECT_EQ(ofIdentity(identityMatches(1000, 4, 2.99F)).confidence, 0);
}

TEST(SignificanceTest, CountsTheHypothesesTried) {
  const Correspondences matches = identityMatches(100, 30, 0.99F);
  EXPECT_EQ(ofIdentity(matches, 10000).confidence, ofIdentity(matches, 0).confidence);
  EXPECT_NEAR(ofIdentity(matches, 1000000).confidence, 99.53, 0.01);
}

TEST(SignificanceTest, CountsEveryPlaceOnce) {
  const Correspondences once = identityMatches(300, 20, 0.99F);
  Correspondences repeated = once;
  for (std::size_t i = 0; i < 20; ++i)  // another scale at nearly the same places
    repeated.add({once.left_x[i] + 4, once.left_y[i] - 2}, {once.right_x[i] + 4, once.right_y[i] - 2});
  EXPECT_EQ(ofIdentity(repeated).agreements, 20u);
  EXPECT_LE(ofIdentity(repeated).confidence, ofIdentity(once).confidence);
}

TEST(SignificanceTest, SqueezingTheImageIntoOnePointIsNoEvidence) {
  Correspondences hub;
  hub.left_size = hub.right_size = {640, 480};
  Random random(1);
  for (std::size_t i = 0; i < 400; ++i) {
    const cv::Point2d right = cv::Point2d(300, 200) + 2 * normalPoint(random);
    hub.add(uniformPoint(random, 640, 480), right);
  }
  SignificanceTest test;
  test.assign(hub);
  EXPECT_LT(test.homography({1e-3, 0, 300, 0, 1e-3, 200, 0, 0, 1}, 0).confidence, 0.01);
}

TEST(SignificanceTest, CrowdedPointsAgreeByChance) {
  // Two crowds of matches in any order: the crowds correspond, the matches do not.
  Correspondences crowds = identityMatches(300, 0, 0);
  Random random(1);
  for (std::size_t i = 0; i < 60; ++i) {
    const cv::Point2d right = cv::Point2d(100, 100) + uniformPoint(random, 60, 60);
    crowds.add(cv::Point2d(100, 100) + uniformPoint(random, 60, 60), right);
  }
  EXPECT_LT(ofIdentity(crowds).confidence, 0.01);
}

TEST(SignificanceTest, FundamentalMatrix) {
  const Scene scene = stereoScene({600, 0.5, 0.5, 2});
  SignificanceTest test;
  test.assign(scene.matches);
  const Significance found = test.fundamental(scene.model, 0);
  EXPECT_GT(found.confidence, 100);
  EXPECT_LE(found.threshold, 2);
  EXPECT_GT(found.agreements, 200u);
  const cv::Matx33d unrelated(0, 0, 0, 0, 0, 1, -0.75, 0, 0);  // y' = 0.75 x
  EXPECT_LT(test.fundamental(unrelated, 0).confidence, 0.01);
  EXPECT_EQ(test.fundamental(cv::Matx33d::zeros(), 0).confidence, 0);
}

/// Matches whose right points have nothing to do with the left ones, `copies` of each nearly at its place.
Correspondences randomMatches(std::size_t places, int copies, std::uint64_t seed) {
  Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  Random random(seed);
  for (std::size_t i = 0; i < places; ++i) {
    const cv::Point2d left = uniformPoint(random, 640, 480), right = uniformPoint(random, 640, 480);
    for (int copy = 0; copy < copies; ++copy) {
      const cv::Point2d noisy_right = right + normalPoint(random);
      matches.add(left + normalPoint(random), noisy_right);
    }
  }
  return matches;
}

TEST(SignificanceTest, MatchesThatAgreeWithTheirNeighboursAreSignificant) {
  const Scene scene = homographyScene({400, 0.3, 1.0, 3});
  SignificanceTest test;
  test.assign(scene.matches);
  const Significance found = test.local(scene.inlier);
  EXPECT_GT(found.confidence, 50);
  EXPECT_LE(found.threshold, 5);
  EXPECT_GT(found.agreements, 30u);
  // Only selected matches count.
  std::vector<std::uint8_t> half = scene.inlier;
  for (std::size_t i = 0; i < half.size(); i += 2) half[i] = 0;
  EXPECT_GT(test.local(half).confidence, 10);
  EXPECT_LT(test.local(half).confidence, 0.7 * found.confidence);
}

TEST(SignificanceTest, CopiesOfAMatchDoNotPredictEachOther) {
  SignificanceTest test;
  test.assign(randomMatches(100, 8, 1));
  EXPECT_LT(test.local(std::vector<std::uint8_t>(800, 1)).confidence, 0.01);
}

TEST(ConfidenceOf, IsThatOfTheModelOrElseOfTheMask) {
  const Scene plane = homographyScene({400, 0.3, 1.0, 3}), space = stereoScene({400, 0.6, 0.5, 3});
  Selection selection;
  selection.mask = plane.inlier;
  SignificanceTest test;
  test.assign(plane.matches);
  EXPECT_EQ(confidenceOf(plane.matches, selection, 0, Workspace::ofThread()),
            test.local(plane.inlier).confidence);
  selection.model_kind = ModelKind::kHomography;
  selection.model = plane.model;
  EXPECT_EQ(confidenceOf(plane.matches, selection, 100000, Workspace::ofThread()),
            test.homography(plane.model, 100000).confidence);
  selection.mask.assign(400, 0);
  EXPECT_EQ(confidenceOf(plane.matches, selection, 0, Workspace::ofThread()), 0);
  selection.mask = space.inlier;
  selection.model_kind = ModelKind::kFundamental;
  selection.model = space.model;
  test.assign(space.matches);
  EXPECT_EQ(confidenceOf(space.matches, selection, 50000, Workspace::ofThread()),
            test.fundamental(space.model, 50000).confidence);
}

TEST(ConfidenceOf, IsZeroWhereMatchesAreRandom) {
  for (const std::string name : {"gms", "lpm", "lpm:v1", "lpm:v2", "vfc", "usac", "usac:f"}) {
    const bool search = name.rfind("usac", 0) == 0;
    const auto selector = createSelector(name, search ? OptionMap{{"max_iterations", "3000"}} : OptionMap{});
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      for (const std::size_t n : {50, 500, 2000}) {
        const Correspondences matches = randomMatches(n, 1, seed);
        const Selection selection = selector->select(matches);
        EXPECT_LE(confidenceOf(matches, selection, static_cast<std::uint64_t>(selection.iterations),
                               Workspace::ofThread()),
                  1)
            << name << " " << n << " " << seed;
      }
    }
  }
}

TEST(SignificanceTest, DegenerateMatchesAndModels) {
  SignificanceTest test;
  for (const std::size_t n : {0, 1, 3, 5, 50}) {
    Correspondences matches;
    for (std::size_t i = 0; i < n; ++i) matches.add({5, 5}, {7, 7});
    test.assign(matches);
    EXPECT_EQ(test.homography(cv::Matx33d::eye(), 0).confidence, 0);
    EXPECT_EQ(test.homography(cv::Matx33d::zeros(), 0).confidence, 0);
    EXPECT_EQ(test.homography({1e308, -1e308, 0, 0, 1e308, 0, 0, 0, 1}, 0).confidence, 0);
    EXPECT_EQ(test.homography({1, 0, 0, 0, 1, 0, 1e-310, 0, 1e-310}, 0).confidence, 0);
    EXPECT_EQ(test.fundamental({0, 0, 0, 0, 0, -1, 0, 1, 0}, 0).confidence, 0);
    EXPECT_EQ(test.local(std::vector<std::uint8_t>(n, 1)).confidence, 0);
  }
}

TEST(SignificanceTest, DoesNotDependOnTheOrderOfTheInput) {
  const Scene scene = homographyScene({400, 0.3, 1.0, 3});
  std::vector<std::uint32_t> reversed(scene.matches.size());
  std::iota(reversed.rbegin(), reversed.rend(), 0U);
  std::vector<std::uint8_t> mask(scene.inlier.rbegin(), scene.inlier.rend());
  SignificanceTest forward, backward;
  forward.assign(scene.matches);
  backward.assign(scene.matches.subset(reversed));
  EXPECT_EQ(forward.homography(scene.model, 0).confidence, backward.homography(scene.model, 0).confidence);
  EXPECT_EQ(forward.fundamental(scene.model, 0).confidence, backward.fundamental(scene.model, 0).confidence);
  EXPECT_EQ(forward.local(scene.inlier).confidence, backward.local(mask).confidence);
}

}  // namespace
}  // namespace corrsel::core
