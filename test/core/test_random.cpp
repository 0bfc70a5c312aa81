#include <gtest/gtest.h>

#include <map>
#include <set>

#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

// Golden values come from a separate implementation of xoshiro256++ and splitmix64 with whole numbers of any
// size.
TEST(Random, GivesTheNumbersOfXoshiro256PlusPlus) {
  const std::pair<std::uint64_t, std::vector<std::uint64_t>> golden[] = {
      {0,
       {0x53175d61490b23df, 0x61da6f3dc380d507, 0x5c0fdf91ec9a7bfc, 0x02eebf8c3bbe5e1a, 0x7eca04ebaf4a5eea}},
      {1,
       {0xcfc5d07f6f03c29b, 0xbf424132963fe08d, 0x19a37d5757aaf520, 0xbf08119f05cd56d6, 0x2f47184b86186fa4}},
      {12345,
       {0x8d948a82def8a568, 0x3477f953796702a0, 0x15caa2fce6db8d69, 0x2cef8853c20c6dd0, 0x43ff3fff9c039cd9}},
      {~0ULL,
       {0x56ccf8ce948e27b2, 0xe68588432e5a5b90, 0xe3e9b5a48119ca8b, 0x460f19495532ae73, 0xa7d62040ea9263e1}},
  };
  for (const auto& [seed, numbers] : golden) {
    Random random(seed);
    for (const std::uint64_t number : numbers) EXPECT_EQ(random.next(), number) << "seed " << seed;
  }
  EXPECT_EQ(Random(12345).uniform(), 0x1.1b291505bdf14p-1);
  EXPECT_EQ(Random().next(), 0x53175d61490b23dfu);
}

TEST(Random, GivesTheIndicesOfLemiresMethod) {
  Random small(7), large(7);
  for (const std::uint32_t index : {0u, 1u, 7u, 4u, 9u, 4u, 7u, 3u, 9u, 0u, 1u, 1u}) {
    EXPECT_EQ(small.index(10), index);
  }
  // Here every third draw is rejected.
  for (const std::uint32_t index :
       {166081309u, 516347562u, 2152728384u, 1281629457u, 2890978564u, 2171721285u}) {
    EXPECT_EQ(large.index(3000000000u), index);
  }
  for (int i = 0; i < 100; ++i) EXPECT_EQ(small.index(1), 0u);
}

/// Chi-square of observed counts against equal shares.
double chiSquare(const std::vector<int>& counts, double draws) {
  double sum = 0;
  const double expected = draws / double(counts.size());
  for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

TEST(Random, IndexIsUniform) {
  Random random(3);
  for (const std::uint32_t bound : {2u, 7u, 100u}) {
    std::vector<int> counts(bound, 0);
    for (int i = 0; i < 100000; ++i) {
      const std::uint32_t index = random.index(bound);
      ASSERT_LT(index, bound);
      ++counts[index];
    }
    const double freedom = bound - 1;
    EXPECT_LT(chiSquare(counts, 100000), freedom + 4 * std::sqrt(2 * freedom)) << bound;
  }
}

TEST(Random, UniformStaysInItsRange) {
  Random random(4);
  double sum = 0, low = 1, high = 0, shifted = 0;
  for (int i = 0; i < 100000; ++i) {
    const double u = random.uniform();
    low = std::min(low, u);
    high = std::max(high, u);
    sum += u;
    const double v = random.uniform(-3, 5);
    ASSERT_TRUE(v >= -3 && v < 5);
    shifted += v;
  }
  EXPECT_GE(low, 0);
  EXPECT_LT(low, 1e-3);
  EXPECT_LT(high, 1);
  EXPECT_GT(high, 1 - 1e-3);
  EXPECT_NEAR(sum / 100000, 0.5, 0.005);
  EXPECT_NEAR(shifted / 100000, 1, 0.04);
}

TEST(Random, NormalHasMeanZeroAndVarianceOne) {
  Random random(5);
  double sum = 0, squares = 0;
  int beyond_one = 0;
  for (int i = 0; i < 100000; ++i) {
    const double z = random.normal();
    ASSERT_LE(std::abs(z), 6);
    sum += z;
    squares += z * z;
    beyond_one += std::abs(z) > 1;
  }
  EXPECT_NEAR(sum / 100000, 0, 0.015);
  EXPECT_NEAR(squares / 100000, 1, 0.02);
  EXPECT_NEAR(beyond_one / 100000.0, 0.317, 0.01);
}

TEST(Random, SampleDrawsEverySubsetEquallyOften) {
  Random random(6);
  std::map<std::set<std::uint32_t>, int> subsets;
  std::uint32_t drawn[3];
  for (int i = 0; i < 70000; ++i) {
    random.sample(7, 3, drawn);
    const std::set<std::uint32_t> subset(drawn, drawn + 3);
    ASSERT_EQ(subset.size(), 3u);
    ASSERT_LT(*subset.rbegin(), 7u);
    ++subsets[subset];
  }
  ASSERT_EQ(subsets.size(), 35u);
  std::vector<int> counts;
  for (const auto& entry : subsets) counts.push_back(entry.second);
  EXPECT_LT(chiSquare(counts, 70000), 34 + 4 * std::sqrt(2 * 34.0));
}

TEST(Random, SampleMayTakeAll) {
  Random random(7);
  std::uint32_t drawn[8] = {0, 0, 0, 0, 0, 0, 0, 99};
  random.sample(7, 7, drawn);
  EXPECT_EQ(std::set<std::uint32_t>(drawn, drawn + 7), (std::set<std::uint32_t>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(drawn[7], 99u);
  random.sample(1, 1, drawn);
  EXPECT_EQ(drawn[0], 0u);
  random.sample(3, 0, drawn);
}

}  // namespace
}  // namespace corrsel::core
