#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "tracking/brightness.h"

namespace corrsel::core {
namespace {

std::vector<double> values(std::size_t n) {
  std::vector<double> result;
  for (std::size_t i = 0; i < n; ++i) result.push_back(20 + static_cast<double>(i * 37 % 200));
  return result;
}

std::vector<double> mapped(const std::vector<double>& of, const Brightness& map) {
  std::vector<double> result;
  for (const double value : of) result.push_back(map(value));
  return result;
}

TEST(Brightness, IsFoundAmongOutliers) {
  const std::vector<double> now = values(100);
  std::vector<double> expected = mapped(now, {1.3, -12});
  for (std::size_t i = 0; i < 20; ++i) expected[5 * i] += 60;
  const Brightness fit = fitBrightness(now, expected, {});
  EXPECT_NEAR(fit.gain, 1.3, 0.02);
  EXPECT_NEAR(fit.offset, -12, 3);
}

TEST(Brightness, StaysWhereNothingIsGained) {
  const Brightness current{1.1, 3};
  const auto isCurrent = [&](const std::vector<double>& now, const std::vector<double>& expected) {
    const Brightness fit = fitBrightness(now, expected, current);
    return fit.gain == current.gain && fit.offset == current.offset;
  };
  const std::vector<double> now = values(100);
  EXPECT_TRUE(isCurrent(now, mapped(now, {1.1, 3.3}))) << "a small difference";
  EXPECT_FALSE(isCurrent(now, mapped(now, {1.1, 9})));
  EXPECT_TRUE(isCurrent(values(19), mapped(values(19), {1.1, 9}))) << "too few values";
  EXPECT_TRUE(isCurrent(now, mapped(now, {6, 0}))) << "too large a gain";
  EXPECT_TRUE(isCurrent(std::vector<double>(50, 80), std::vector<double>(50, 120))) << "no contrast";
  std::vector<double> unrelated = now;
  std::reverse(unrelated.begin(), unrelated.end());
  EXPECT_TRUE(isCurrent(now, unrelated));
}

}  // namespace
}  // namespace corrsel::core
