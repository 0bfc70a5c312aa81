#include <gtest/gtest.h>

#include "corrsel/evaluation/statistics.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

TEST(Statistics, Mean) {
  EXPECT_DOUBLE_EQ(mean({1, 2, 6}), 3);
  EXPECT_DOUBLE_EQ(mean({-4}), -4);
  EXPECT_TRUE(std::isnan(mean({})));
}

TEST(Statistics, QuantileInterpolates) {
  const std::vector<double> values = {40, 10, 30, 20};
  EXPECT_DOUBLE_EQ(quantile(values, 0), 10);
  EXPECT_DOUBLE_EQ(quantile(values, 1), 40);
  EXPECT_DOUBLE_EQ(quantile(values, 0.5), 25);
  EXPECT_DOUBLE_EQ(quantile(values, 1.0 / 3), 20);
  EXPECT_DOUBLE_EQ(quantile(values, 0.95), 38.5);
  EXPECT_DOUBLE_EQ(quantile(values, 0.025), 10.75);
  EXPECT_DOUBLE_EQ(quantile({7}, 0.3), 7);
  EXPECT_DOUBLE_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(quantile({1, 2, infinite}, 0.5), 2);
  EXPECT_EQ(quantile({1, 2, infinite, infinite}, 0.5), infinite);
  EXPECT_EQ(quantile({1, infinite, infinite}, 0.5), infinite);
}

TEST(Statistics, BootstrapIntervalHasTheRightWidth) {
  // Half zeros, half ones: the mean of 400 has the standard deviation 0.025.
  std::vector<double> values(400, 0);
  std::fill_n(values.begin(), 200, 1.0);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Interval interval = bootstrapMean(values, seed);
    EXPECT_NEAR(interval.low, 0.5 - 1.96 * 0.025, 0.006);
    EXPECT_NEAR(interval.high, 0.5 + 1.96 * 0.025, 0.006);
  }
  // Of two values a quarter of the resamples has both the same: the interval reaches from one to the other.
  const Interval two = bootstrapMean({3, 9}, 1);
  EXPECT_EQ(two.low, 3);
  EXPECT_EQ(two.high, 9);
}

TEST(Statistics, BootstrapIntervalIsThatOfItsSeed) {
  const std::vector<double> values = {0.9, 0.3, 0.55, 0.8, 0.1, 0.77, 0.62};
  const Interval a = bootstrapMean(values, 5), b = bootstrapMean(values, 5), c = bootstrapMean(values, 6);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_TRUE(a.low != c.low || a.high != c.high);
  EXPECT_LT(a.low, mean(values));
  EXPECT_GT(a.high, mean(values));
}

TEST(Statistics, BootstrapOfOneOrNone) {
  EXPECT_EQ(bootstrapMean({4}, 1).low, 4);
  EXPECT_EQ(bootstrapMean({4}, 1).high, 4);
  EXPECT_TRUE(std::isnan(bootstrapMean({}, 1).low) && std::isnan(bootstrapMean({}, 1).high));
  EXPECT_EQ(bootstrapMean({2, 2, 2}, 1).low, 2);
}

}  // namespace
}  // namespace corrsel::core
