#include <gtest/gtest.h>

#include <cmath>

#include "auto/thresholds.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Squared errors of 500 inliers with noise in `dimensions` coordinates, and of 300 outliers.
std::vector<double> errors(int dimensions, double sigma) {
  Random random(1);
  std::vector<double> squared;
  for (int i = 0; i < 500; ++i) {
    const cv::Point2d noise = sigma * normalPoint(random);
    squared.push_back(noise.x * noise.x + (dimensions == 2 ? noise.y * noise.y : 0));
  }
  for (int i = 0; i < 300; ++i) squared.push_back(std::pow(random.uniform(0, 400), 2));
  return squared;
}

TEST(Thresholds, BeginAtTheDefaults) {
  const Thresholds thresholds{AutoOptions()};
  EXPECT_EQ(thresholds.homography, 5);
  EXPECT_EQ(thresholds.fundamental, 1.5);
}

TEST(Thresholds, KeepWhatTheUserHasGiven) {
  AutoOptions options;
  options.threshold = 2;
  options.fundamental_threshold = 0.7;
  Thresholds thresholds(options);
  thresholds.adaptHomography(errors(2, 3));
  thresholds.adaptFundamental(errors(1, 2));
  EXPECT_EQ(thresholds.homography, 2);
  EXPECT_EQ(thresholds.fundamental, 0.7);
}

TEST(Thresholds, StayWhereTheFeaturesArePrecise) {
  Thresholds thresholds{AutoOptions()};
  thresholds.adaptHomography(errors(2, 1));
  thresholds.adaptFundamental(errors(1, 0.4));
  EXPECT_EQ(thresholds.homography, 5);
  EXPECT_EQ(thresholds.fundamental, 1.5);
}

TEST(Thresholds, GrowWithTheNoise) {
  Thresholds thresholds{AutoOptions()};
  thresholds.adaptHomography(errors(2, 2.4));
  thresholds.adaptFundamental(errors(1, 1.2));
  EXPECT_NEAR(thresholds.homography, 2.65 * 2.4, 0.6);
  EXPECT_NEAR(thresholds.fundamental, 2.17 * 1.2, 0.3);
}

TEST(Thresholds, HaveAnUpperBound) {
  Thresholds thresholds{AutoOptions()};
  thresholds.adaptHomography(errors(2, 6));
  EXPECT_LE(thresholds.homography, 7.5);
  thresholds.adaptFundamental(errors(1, 30));
  EXPECT_LE(thresholds.fundamental, 4.5);
}

TEST(Thresholds, StayWithoutInliers) {
  Thresholds thresholds{AutoOptions()};
  thresholds.adaptHomography({});
  thresholds.adaptHomography({1, 2, 3});
  EXPECT_EQ(thresholds.homography, 5);
}

TEST(SelectWithin, TakesErrorsUpToTheThreshold) {
  std::vector<std::uint8_t> mask;
  selectWithin({0, 4, 4.01, std::numeric_limits<double>::infinity()}, 2, mask);
  EXPECT_EQ(mask, (std::vector<std::uint8_t>{1, 1, 0, 0}));
}

}  // namespace
}  // namespace corrsel::core
