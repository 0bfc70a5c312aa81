#include <gtest/gtest.h>

#include "search/ordering.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Ordering, ShuffleDependsOnTheMatchesAlone) {
  Correspondences m = homographyScene({500, 0.5, 0.5, 1}).matches;
  // Duplicates, and matches that differ in one coordinate.
  for (std::size_t i = 0; i < 40; ++i) {
    m.left_x[i] = m.left_x[i + 40];
    m.left_y[i] = m.left_y[i + 40];
    m.right_x[i] = m.right_x[i + 40];
    if (i % 2 == 0) m.right_y[i] = m.right_y[i + 40];
  }
  Ordering ordering;
  std::vector<std::uint32_t> rows, other;
  ordering.shuffle(m, 7, rows);
  std::vector<std::uint32_t> sorted = rows;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < 500; ++i) ASSERT_EQ(sorted[i], i);
  const std::vector<std::uint32_t> order = permutation(500, 2);
  const Correspondences permuted = m.subset(order);
  ordering.shuffle(permuted, 7, other);
  const Correspondences a = m.subset(rows), b = permuted.subset(other);
  EXPECT_EQ(a.left_x, b.left_x);
  EXPECT_EQ(a.right_y, b.right_y);
  EXPECT_EQ(a.distance, b.distance);
  ordering.shuffle(m, 8, other);
  EXPECT_NE(rows, other);
}

TEST(Ordering, EveryStretchIsAFairSample) {
  // The inliers come first in the input.
  const Scene scene = homographyScene({4000, 0.5, 0.5, 1});
  Ordering ordering;
  std::vector<std::uint32_t> rows;
  ordering.shuffle(scene.matches, 0, rows);
  for (std::size_t begin = 0; begin < 4000; begin += 400) {
    int right = 0;
    for (std::size_t i = begin; i < begin + 400; ++i) right += scene.inlier[rows[i]];
    EXPECT_NEAR(right, 200, 50) << begin;
  }
}

TEST(Ordering, QualityIsTheRatioOrTheDistance) {
  Correspondences m;
  for (int i = 0; i < 6; ++i) m.add({float(i), 0}, {0, float(i)});
  const std::vector<std::uint32_t> rows = {5, 4, 3, 2, 1, 0};
  Ordering ordering;
  std::vector<std::uint32_t> positions;
  EXPECT_FALSE(ordering.byQuality(m, rows, positions));
  m.distance = {10, 20, 30, NAN, 50, 20};
  ASSERT_TRUE(ordering.byQuality(m, rows, positions));
  // Rows 0, 5, 1 (equal: in the order of `rows`), 2, 4, 3.
  EXPECT_EQ(positions, (std::vector<std::uint32_t>{5, 0, 4, 3, 1, 2}));
  m.second_distance = {10, 40, 40, 80, 0, NAN};  // ratios 1, 0.5, 0.75, NaN, infinite, NaN
  ASSERT_TRUE(ordering.byQuality(m, rows, positions));
  EXPECT_EQ(positions, (std::vector<std::uint32_t>{4, 3, 5, 1, 0, 2}));
  m.distance.assign(6, NAN);
  EXPECT_FALSE(ordering.byQuality(m, rows, positions));
}

TEST(Ordering, ProbabilitiesOrderMatchesWithoutDistances) {
  Correspondences m;
  for (int i = 0; i < 5; ++i) m.add({float(i), 0}, {0, float(i)});
  const std::vector<std::uint32_t> rows = {4, 3, 2, 1, 0};
  m.probability = {0.25F, 1, NAN, 0.25F, 0.5F};
  Ordering ordering;
  std::vector<std::uint32_t> positions;
  ASSERT_TRUE(ordering.byQuality(m, rows, positions));
  // Rows 1, 4, 3, 0 (equal: in the order of `rows`), 2.
  EXPECT_EQ(positions, (std::vector<std::uint32_t>{3, 0, 1, 4, 2}));
  m.probability.assign(5, NAN);
  EXPECT_FALSE(ordering.byQuality(m, rows, positions));
  m.probability = {1, 0, 0, 0, 0};
  m.distance = {5, 4, 3, 2, 1};
  ASSERT_TRUE(ordering.byQuality(m, rows, positions)) << "distances come before probabilities";
  EXPECT_EQ(positions, (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
}

TEST(Ordering, EqualMatchesAreShuffledByTheirProbabilities) {
  Correspondences m;
  for (int i = 0; i < 20; ++i) m.add({1, 2}, {3, 4});
  for (int i = 0; i < 20; ++i) m.probability.push_back(float(i) / 20);
  Ordering ordering;
  std::vector<std::uint32_t> rows, other;
  ordering.shuffle(m, 7, rows);
  const Correspondences permuted = m.subset(permutation(20, 2));
  ordering.shuffle(permuted, 7, other);
  EXPECT_EQ(m.subset(rows).probability, permuted.subset(other).probability);
}

}  // namespace
}  // namespace corrsel::core
