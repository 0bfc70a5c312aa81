#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "calibrated/search_set.h"

namespace corrsel::core {
namespace {

using Rows = std::vector<std::uint32_t>;

/// Matches between points that have a number in their image.
Correspondences matchesOf(const std::vector<std::pair<int, int>>& points) {
  Correspondences matches;
  for (const auto& [left, right] : points) {
    matches.left_x.push_back(10.0F * float(left));
    matches.left_y.push_back(7);
    matches.right_x.push_back(5);
    matches.right_y.push_back(20.0F * float(right));
  }
  return matches;
}

TEST(SearchSet, KeepsTheSmallestDistanceOfARightPoint) {
  Correspondences matches = matchesOf({{0, 0}, {1, 0}, {2, 0}, {3, 1}});
  matches.distance = {3, 1, 2, 9};
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2, 3}), (Rows{1, 3}));
}

TEST(SearchSet, KeepsTheBestRatioOfALeftPoint) {
  Correspondences matches = matchesOf({{0, 0}, {0, 1}, {0, 2}, {1, 3}});
  matches.distance = {1, 3, 2, 9};
  matches.second_distance = {2, 10, 3, 9};  // ratios 0.5, 0.3, 0.67, 1
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2, 3}), (Rows{1, 3}));
}

TEST(SearchSet, KeepsTheLargestProbabilityWithoutDistances) {
  Correspondences matches = matchesOf({{0, 0}, {1, 0}, {1, 1}, {1, 2}});
  matches.probability = {0.5F, 0.9F, 0.25F, 0.95F};
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2, 3}), (Rows{3}));
  matches.distance = {1, 2, 3, 4};
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2, 3}), (Rows{0, 2})) << "distances come first";
}

TEST(SearchSet, RightPointsComeFirst) {
  // The best match of the left point loses its right point to another match.
  Correspondences matches = matchesOf({{0, 0}, {1, 0}, {0, 1}});
  matches.distance = {2, 1, 5};
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2}), (Rows{1, 2}));
}

TEST(SearchSet, KeepsTheFirstWithoutDistancesAndOfEqualOnes) {
  Correspondences matches = matchesOf({{0, 0}, {1, 0}, {1, 1}});
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2}), (Rows{0, 2}));
  EXPECT_EQ(SearchSet().choose(matches, {1, 0, 2}), (Rows{1}));
  matches.distance = {1, 1, 1};
  EXPECT_EQ(SearchSet().choose(matches, {1, 0, 2}), (Rows{1}));
}

TEST(SearchSet, UnknownQualityIsTheWorst) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Correspondences matches = matchesOf({{0, 0}, {0, 1}});
  matches.distance = {1, 2};
  matches.second_distance = {nan, 2};
  EXPECT_EQ(SearchSet().choose(matches, {0, 1}), (Rows{1}));
  EXPECT_EQ(SearchSet().choose(matches, {1, 0}), (Rows{1}));
}

TEST(SearchSet, TakesOnlyTheGivenRowsInTheirOrder) {
  Correspondences matches = matchesOf({{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 0}});
  matches.distance = {2, 1, 1, 1, 1};
  SearchSet set;
  EXPECT_EQ(set.choose(matches, {3, 0, 2}), (Rows{3, 0, 2}));
  EXPECT_EQ(set.choose(matches, {3, 0, 2, 4}), (Rows{3, 2, 4}));
  EXPECT_EQ(set.rows(), (Rows{3, 2, 4}));
  EXPECT_TRUE(set.choose(matches, {}).empty());
}

TEST(SearchSet, PointsWithinAThousandthOfAPixelAreOne) {
  Correspondences matches = matchesOf({{0, 0}, {1, 0}, {2, 0}});
  matches.right_y = {0, 1e-4F, 0.01F};
  EXPECT_EQ(SearchSet().choose(matches, {0, 1, 2}), (Rows{0, 2}));
}

}  // namespace
}  // namespace corrsel::core
