#include <gtest/gtest.h>

#include <limits>

#include "selectors/parts/trusted_set.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// Matches with the given right points and distances; the left points are all different.
Correspondences matchesWith(const std::vector<cv::Point2f>& right, std::vector<float> distance,
                            std::vector<float> second) {
  Correspondences m;
  for (std::size_t i = 0; i < right.size(); ++i) m.add({10 * float(i), 5}, right[i]);
  m.distance = std::move(distance);
  m.second_distance = std::move(second);
  return m;
}

TEST(TrustedSet, TakesRatiosBelowTheLimit) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinite = std::numeric_limits<float>::infinity();
  std::vector<cv::Point2f> right;
  for (int i = 0; i < 9; ++i) right.emplace_back(float(20 * i), 0.F);
  const Correspondences m =
      matchesWith(right, {1, 8, 9, 9.1F, 0, nan, 1, 1, -1}, {10, 10, 10, 10, 0, 10, nan, infinite, 10});
  TrustedSet trusted;
  trusted.find(m, 0.9);
  EXPECT_EQ(trusted.mask(), (Mask{1, 1, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(trusted.size(), 2u);
  trusted.find(m, 0.91);
  EXPECT_EQ(trusted.size(), 3u);
}

TEST(TrustedSet, TakesTheSmallestRatioOfEveryRightPoint) {
  // The first three end in one px, and so do the next two with equal ratios, in the order of the left points.
  const Correspondences m =
      matchesWith({{7.6F, 3}, {8, 3.4F}, {8.4F, 2.6F}, {-0.4F, 0}, {0.4F, 0}, {8.6F, 3}}, {5, 4, 6, 3, 3, 8},
                  std::vector<float>(6, 10.F));
  TrustedSet trusted;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const std::vector<std::uint32_t> order = permutation(m.size(), seed);
    trusted.find(m.subset(order), 0.9);
    EXPECT_EQ(trusted.mask(), reordered(Mask{0, 1, 0, 1, 0, 1}, order));
    EXPECT_EQ(trusted.size(), 3u);
  }
}

TEST(TrustedSet, NamesTheMissingColumn) {
  Correspondences m = matchesWith({{1, 1}}, {1}, {2});
  EXPECT_EQ(TrustedSet::missingInput(m, "x"), "");
  m.second_distance.clear();
  EXPECT_EQ(TrustedSet::missingInput(m, "x"), "x needs the column second_distance");
  m.distance.clear();
  EXPECT_EQ(TrustedSet::missingInput(m, "x"), "x needs the column distance");
  EXPECT_EQ(TrustedSet::missingInput({}, "x"), "");
}

}  // namespace
}  // namespace corrsel::core
