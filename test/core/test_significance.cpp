#include <gtest/gtest.h>

#include "consensus/significance.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Matches on a grid of places of which `agreeing` follow the identity with the given error; the others end
/// far from it.
Correspondences identityMatches(std::size_t n, std::size_t agreeing, float error) {
  Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = static_cast<float>(12 + 18 * (i % 34)), y = static_cast<float>(10 + 15 * (i / 34));
    matches.add({x, y}, i < agreeing ? cv::Point2f(x + error, y) : cv::Point2f(639 - x, 479 - y));
  }
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
  EXPECT_NEAR(ofIdentity(identityMatches(300, 150, 1.99F)).confidence, 548.02, 0.01);
  const Significance few = ofIdentity(identityMatches(1000, 12, 2.99F));
  EXPECT_NEAR(few.confidence, 8.05, 0.02);
  EXPECT_EQ(few.threshold, 3);
  EXPECT_EQ(few.agreements, 12u);
}

TEST(SignificanceTest, CountsTheHypothesesTried) {
  const Correspondences matches = identityMatches(100, 30, 0.99F);
  EXPECT_EQ(ofIdentity(matches, 10000).confidence, ofIdentity(matches, 0).confidence);
  EXPECT_NEAR(ofIdentity(matches, 1000000).confidence, 99.53, 0.01);
}

TEST(SignificanceTest, CountsEveryPlaceOnce) {
  const Correspondences once = identityMatches(300, 20, 0.99F);
  Correspondences repeated = once;
  for (std::size_t i = 0; i < 20; ++i)  // a second orientation at the same places
    repeated.add({once.left_x[i], once.left_y[i]}, {once.right_x[i], once.right_y[i]});
  EXPECT_EQ(ofIdentity(repeated).agreements, 20u);
  EXPECT_LE(ofIdentity(repeated).confidence, ofIdentity(once).confidence);
  Correspondences hub;
  hub.left_size = hub.right_size = {640, 480};
  for (std::size_t i = 0; i < 200; ++i)
    hub.add({static_cast<float>(20 + i * 3), static_cast<float>(20 + i * 7 % 400)}, {300, 200});
  SignificanceTest test;
  test.assign(hub);
  // Squeezes the image into the one right point.
  EXPECT_EQ(test.homography({1e-4, 0, 300, 0, 1e-4, 200, 0, 0, 1}, 0).confidence, 0);
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
  EXPECT_GT(forward.local(scene.inlier).confidence, 20);
}

}  // namespace
}  // namespace corrsel::core
