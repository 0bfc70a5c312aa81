#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "reference/rank_distance.h"

namespace corrsel::core {
namespace {

using List = std::vector<std::uint32_t>;

double distanceOf(const RankDistance& distance, const List& left, const List& right) {
  std::vector<std::uint8_t> places;
  for (const std::uint32_t number : right) {
    const auto found = std::find(left.begin(), left.end(), number);
    places.push_back(found != left.end() ? std::uint8_t(found - left.begin()) : RankDistance::kAbsent);
  }
  return distance(places.data());
}

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
    List list(std::size_t(k), 0U);
    std::iota(list.begin(), list.end(), 100U);
    List reversed(list.rbegin(), list.rend()), others = list;
    for (std::uint32_t& number : others) number += 100;
    EXPECT_EQ(distanceOf(distance, list, list), 0);
    EXPECT_NEAR(distanceOf(distance, list, reversed), 0.5, 1e-12);
    EXPECT_NEAR(distanceOf(distance, list, others), 1, 1e-12);
    // The first two exchange their ranks: |1 - 2| / 1, twice.
    List changed = list;
    std::swap(changed[0], changed[1]);
    EXPECT_NEAR(distanceOf(distance, list, changed), 2 / distance.largest(), 1e-12);
    // A stranger in the middle leaves the ranks among the common ones as they are.
    changed = list;
    changed[3] = 7;
    EXPECT_NEAR(distanceOf(distance, list, changed), 2 * distance.perStranger() / distance.largest(), 1e-12);
    // Longer rankings are cut off.
    changed = list;
    changed.push_back(7);
    std::swap(changed[std::size_t(k) - 1], changed[std::size_t(k)]);
    EXPECT_NEAR(distanceOf(distance, list, changed), 2 * distance.perStranger() / distance.largest(), 1e-12);
  }
}

}  // namespace
}  // namespace corrsel::core
