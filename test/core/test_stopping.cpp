#include <gtest/gtest.h>

#include "search/stopping.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// The first number of samples that is enough.
std::uint64_t samplesOf(const StoppingRule& rule) {
  std::uint64_t drawn = 0;
  while (!rule.enough(drawn) && drawn < 10000000) ++drawn;
  return drawn;
}

double allInliers(double inliers, double n, int m) {
  double p = 1;
  for (int k = 0; k < m; ++k) p *= (inliers - k) / (n - k);
  return p;
}

TEST(StoppingRule, CountsSamplesWithoutReplacement) {
  StoppingRule rule(0.99, 100, 4);
  EXPECT_FALSE(rule.enough(1000000000));  // nothing found yet
  rule.setInliers(50);
  EXPECT_EQ(samplesOf(rule), std::uint64_t(std::ceil(std::log(0.01) / std::log1p(-allInliers(50, 100, 4)))));
  rule.setInliers(100);
  EXPECT_EQ(samplesOf(rule), 0u);
  rule.setInliers(3);  // no sample of inliers alone exists
  EXPECT_FALSE(rule.enough(1000000000));
}

TEST(StoppingRule, ConfidenceOneNeverStops) {
  StoppingRule rule(1.0, 100, 4);
  for (const std::size_t inliers : {50, 100}) {
    rule.setInliers(inliers);
    EXPECT_FALSE(rule.enough(1000000000));
  }
}

TEST(StoppingRule, MakesUpForWhatTheSprtLoses) {
  const double p = allInliers(300, 1000, 4);
  StoppingRule rule(0.99, 1000, 4);
  rule.setLoss(0.125, 0);
  rule.setInliers(300);
  EXPECT_EQ(samplesOf(rule), std::uint64_t(std::ceil(std::log(0.01) / std::log1p(-p * 0.875))));
  // 200 samples under the first design, the rest under a second one.
  rule.setLoss(0.02, 200);
  const double left = std::log(0.01) - 200 * std::log1p(-p * 0.875);
  EXPECT_EQ(samplesOf(rule), std::uint64_t(std::ceil(200 + left / std::log1p(-p * 0.98))));
}

TEST(StoppingRule, PrefixShortensTheSearch) {
  StoppingRule rule(0.99, 1000, 4);
  rule.setInliers(200);
  const std::uint64_t all = samplesOf(rule);
  rule.setPrefix(45, 50);
  EXPECT_EQ(samplesOf(rule), std::uint64_t(std::ceil(std::log(0.01) / std::log1p(-allInliers(45, 50, 4)))));
  EXPECT_LT(samplesOf(rule), all);
  rule.setInliers(201);  // another model: its prefix is not known yet
  EXPECT_GT(samplesOf(rule), all / 2);
}

}  // namespace
}  // namespace corrsel::core
