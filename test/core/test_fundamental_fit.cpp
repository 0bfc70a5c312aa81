#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "corrsel/datasets/scene.h"
#include "geometry/fundamental.h"
#include "geometry/fundamental_fit.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Correct matches of a generated scene.
Correspondences inliers(MatchSceneKind kind, std::size_t n, double noise) {
  SceneSpec spec;
  spec.kind = kind;
  spec.n = n;
  spec.inlier_ratio = 1;
  spec.noise = noise;
  spec.seed = 5;
  return makeScene(spec).matches;
}

double largestDistance(const cv::Matx33d& f, const Correspondences& m) {
  double largest = 0;
  for (std::size_t i = 0; i < m.size(); ++i) {
    largest =
        std::max(largest, epipolarLineDistance(f, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]));
  }
  return largest;
}

TEST(FundamentalFit, PassesThroughExactPoints) {
  const Correspondences matches = inliers(MatchSceneKind::kSpace, 20, 0);
  const auto fitted = fitFundamental(matches);
  ASSERT_TRUE(fitted.has_value());
  EXPECT_LT(largestDistance(*fitted, matches), 0.01);
  EXPECT_NEAR(cv::norm(*fitted), 1, 1e-9);
  EXPECT_NEAR(cv::determinant(*fitted), 0, 1e-12);
}

TEST(FundamentalFit, AveragesOverNoisyPoints) {
  const Correspondences noisy = inliers(MatchSceneKind::kSpace, 200, 1);
  const Correspondences exact = inliers(MatchSceneKind::kSpace, 200, 0);
  const auto fitted = fitFundamental(noisy);
  ASSERT_TRUE(fitted.has_value());
  // Nearer to the true geometry than the noise of one point.
  EXPECT_LT(largestDistance(*fitted, exact), 1.0);
  EXPECT_EQ(*fitted, *fitFundamental(noisy));  // the same from run to run
}

TEST(FundamentalFit, NeedsEightPointsInSpace) {
  EXPECT_FALSE(fitFundamental(inliers(MatchSceneKind::kSpace, 7, 0)).has_value());
  EXPECT_FALSE(fitFundamental({}).has_value());
  Correspondences same;
  for (int i = 0; i < 10; ++i) same.add({1, 2}, {3, 4});
  EXPECT_FALSE(fitFundamental(same).has_value());
}

}  // namespace
}  // namespace corrsel::core
