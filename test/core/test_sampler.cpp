#include <gtest/gtest.h>

#include <set>

#include "consensus/sampler.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Sampler, UniformSamplesAreDistinctAndEven) {
  Sampler sampler(20, 4, 1);
  std::vector<int> counts(20, 0);
  std::uint32_t sample[4];
  for (int i = 0; i < 20000; ++i) {
    sampler.draw(sample);
    EXPECT_EQ(std::set<std::uint32_t>(sample, sample + 4).size(), 4u);
    for (const std::uint32_t k : sample) ++counts[k];
  }
  EXPECT_EQ(sampler.drawn(), 20000u);
  EXPECT_EQ(sampler.pool(), 20u);
  for (const int count : counts) EXPECT_NEAR(count, 4000, 300);
}

TEST(Sampler, ProsacGrowsItsPoolAsThePaperSays) {
  const std::vector<std::uint32_t> order = permutation(1000, 3);
  constexpr int kSample = 4;
  // T'_n by the recurrence of the paper on PROSAC.
  std::vector<std::uint64_t> last(1001, 0);
  double t = 200000;
  for (int i = 0; i < kSample; ++i) t *= (4.0 - i) / (1000.0 - i);
  last[4] = 1;
  for (std::size_t n = 4; n < 1000; ++n) {
    const double next = t * (double(n) + 1) / (double(n) + 1 - kSample);
    last[n + 1] = last[n] + std::uint64_t(std::ceil(next - t));
    t = next;
  }
  EXPECT_NEAR(t, 200000, 1);
  Sampler sampler(order, kSample, 1);
  std::uint32_t sample[kSample];
  std::size_t n = 4;
  for (std::uint64_t draw = 1; draw <= 60000; ++draw) {
    while (draw > last[n]) ++n;
    sampler.draw(sample);
    ASSERT_EQ(sampler.pool(), n);
    // The newest member of the pool, and three of those before it.
    ASSERT_EQ(sample[3], order[n - 1]);
    for (int k = 0; k < 3; ++k) {
      const auto rank = std::find(order.begin(), order.end(), sample[k]) - order.begin();
      ASSERT_LT(rank, std::ptrdiff_t(n) - 1);
    }
  }
}

TEST(Sampler, PrefixesTakeTurnsAfterProsac) {
  const std::vector<std::uint32_t> order = permutation(1000, 3);
  std::vector<std::size_t> rank(1000);
  for (std::size_t i = 0; i < 1000; ++i) rank[order[i]] = i;
  Sampler sampler(order, 4, 1, {500, 8});
  std::uint32_t sample[4];
  while (sampler.pool() < 1000) sampler.draw(sample);
  for (int i = 0; i < 100; ++i) sampler.draw(sample);  // the last samples of the pool of all matches
  std::vector<std::size_t> largest(8, 0);
  for (int i = 0; i < 40000; ++i) {
    sampler.draw(sample);
    std::size_t& seen = largest[sampler.drawn() % 8];
    for (const std::uint32_t k : sample) seen = std::max(seen, rank[k] + 1);
  }
  // All matches, the best half, quarter... but 20 at least.
  EXPECT_EQ(largest, (std::vector<std::size_t>{1000, 500, 250, 125, 62, 31, 20, 20}));
  EXPECT_EQ(sampler.pool(), 1000u);
  // With fewer matches than the least prefix, all of them.
  const std::vector<std::uint32_t> few = permutation(10, 3);
  Sampler small(few, 4, 1, {1, 8});
  std::set<std::uint32_t> drawn;
  for (int i = 0; i < 1000; ++i) {
    small.draw(sample);
    drawn.insert(sample, sample + 4);
  }
  EXPECT_EQ(drawn.size(), 10u);
}

TEST(Sampler, ProsacEndsUniform) {
  const std::vector<std::uint32_t> order = permutation(30, 3);
  Sampler sampler(order, 4, 1);
  std::uint32_t sample[4];
  std::uint64_t grown = 0;
  while (sampler.pool() < 30) sampler.draw(sample), ++grown;
  EXPECT_LT(grown, 201000u);
  for (int i = 0; i < 201000; ++i) sampler.draw(sample);
  std::vector<int> counts(30, 0);
  for (int i = 0; i < 30000; ++i) {
    sampler.draw(sample);
    for (const std::uint32_t k : sample) ++counts[k];
  }
  for (const int count : counts) EXPECT_NEAR(count, 4000, 300);
}

TEST(Sampler, SeedDecides) {
  const auto first = [](std::uint64_t seed) {
    Sampler sampler(1000, 7, seed);
    std::vector<std::uint32_t> sample(7);
    sampler.draw(sample.data());
    return sample;
  };
  EXPECT_EQ(first(5), first(5));
  EXPECT_NE(first(5), first(6));
}

}  // namespace
}  // namespace corrsel::core
