#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "selectors/parts/rank_distance.h"

namespace corrsel::core {
namespace {

TEST(RankDistance, HasTheConstantsOfThePaper) {
  const double largest[] = {120.8143, 99.5714, 79.4000}, stranger[] = {3.77545, 3.55612, 3.30833};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(RankDistance(16 - 2 * i).largest(), largest[i], 1e-4);
    EXPECT_NEAR(RankDistance(16 - 2 * i).perStranger(), stranger[i], 1e-4);
  }
}

TEST(RankDistance, ComparesOrders) {
  for (const int k : {12, 14, 16}) {
    const RankDistance distance(k);
    std::vector<std::uint32_t> list(std::size_t(k), 0U);
    std::iota(list.begin(), list.end(), 100U);
    std::vector<std::uint32_t> reversed(list.rbegin(), list.rend()), others = list;
    for (std::uint32_t& number : others) number += 100;
    EXPECT_EQ(distance(list.data(), list.data()), 0);
    EXPECT_NEAR(distance(list.data(), reversed.data()), 0.5, 1e-12);
    EXPECT_NEAR(distance(list.data(), others.data()), 1, 1e-12);
    // The first two exchange their ranks: |1 - 2| / 1, twice.
    std::vector<std::uint32_t> changed = list;
    std::swap(changed[0], changed[1]);
    EXPECT_NEAR(distance(list.data(), changed.data()), 2 / distance.largest(), 1e-12);
    // A stranger in the middle leaves the ranks among the common ones as they are.
    changed = list;
    changed[3] = 7;
    EXPECT_NEAR(distance(list.data(), changed.data()), 2 * distance.perStranger() / distance.largest(),
                1e-12);
  }
}

}  // namespace
}  // namespace corrsel::core
