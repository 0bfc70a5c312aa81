#include <gtest/gtest.h>

#include "reference/cluster_numbers.h"

namespace corrsel::core {
namespace {

constexpr std::uint32_t kNone = ClusterNumbers::kNone;

TEST(ClusterNumbers, TheLargestIsFirstAndEqualOnesAreInTheOrderOfTheirMatches) {
  ClusterNumbers numbers;
  numbers.assign({4, kNone, 2, 1, 1, 2, 2, kNone, 4}, {7, 2, 3, 9, 2});
  EXPECT_EQ(numbers.count(), 3u);
  EXPECT_EQ(numbers[2], 0);
  EXPECT_EQ(numbers[4], 1);
  EXPECT_EQ(numbers[1], 2);
  EXPECT_EQ(numbers[kNone], -1);
}

TEST(ClusterNumbers, ForgetsThePreviousClusters) {
  ClusterNumbers numbers;
  numbers.assign({0, 1}, {1, 1});
  numbers.assign({kNone, 1}, {1, 1});
  EXPECT_EQ(numbers.count(), 1u);
  EXPECT_EQ(numbers[1], 0);
  EXPECT_EQ(numbers[0], -1);
  numbers.assign({}, {});
  EXPECT_EQ(numbers.count(), 0u);
}

}  // namespace
}  // namespace corrsel::core
