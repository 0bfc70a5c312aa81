#include <gtest/gtest.h>

#include "points/match_neighbours.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// The numbers of the nearest members, equal distances by number, without `i` itself or without the nearest.
std::vector<std::uint32_t> nearest(const std::vector<float>& x, const std::vector<float>& y,
                                   const std::vector<std::uint32_t>& members, std::uint32_t i, int listed,
                                   bool compat) {
  std::vector<std::pair<double, std::uint32_t>> sorted;
  for (const std::uint32_t j : members) {
    const double dx = double(x[j]) - x[i], dy = double(y[j]) - y[i];
    if (compat || j != i) sorted.emplace_back(dx * dx + dy * dy, j);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> result;
  for (std::size_t k = compat ? 1 : 0; result.size() < std::size_t(listed); ++k)
    result.push_back(sorted[k].second);
  return result;
}

TEST(MatchNeighbours, ListsTheNearestMembersInBothImages) {
  Correspondences m = homographyScene({300, 0.6, 0.5, 3}).matches;
  for (std::size_t i = 0; i < 100; ++i) m.left_x[i] = std::round(m.left_x[i] / 50) * 50;  // ties
  MatchNeighbours neighbours;
  neighbours.assign(m, true);
  ASSERT_EQ(neighbours.size(), 300u);
  std::vector<std::uint32_t> all(300), some;
  std::iota(all.begin(), all.end(), 0U);
  for (std::uint32_t i = 0; i < 300; i += 3) some.push_back(i);
  for (const bool compat : {false, true}) {
    for (const auto* members : {&all, &some}) {
      neighbours.find(members == &all ? nullptr : members, 7,
                      compat ? MatchNeighbours::Self::kDropNearest : MatchNeighbours::Self::kLeaveOut);
      for (std::uint32_t i = 0; i < 300; ++i) {
        const std::uint32_t* const left = neighbours.left() + i * neighbours.stride();
        const std::uint32_t* const right = neighbours.right() + i * neighbours.stride();
        ASSERT_EQ(std::vector<std::uint32_t>(left, left + 7),
                  nearest(neighbours.left_x, neighbours.left_y, *members, i, 7, compat));
        ASSERT_EQ(std::vector<std::uint32_t>(right, right + 7),
                  nearest(neighbours.right_x, neighbours.right_y, *members, i, 7, compat));
      }
    }
  }
}

TEST(MatchNeighbours, KeepsTheMatchWhereItIsAMember) {
  const Correspondences m = homographyScene({50, 0.6, 0.5, 3}).matches;
  MatchNeighbours neighbours;
  neighbours.assign(m, true);
  const std::vector<std::uint32_t> even = {0, 2, 4, 6, 8, 10, 12};
  neighbours.find(&even, 3, MatchNeighbours::Self::kKeep);
  ASSERT_EQ(neighbours.stride(), 3u);
  EXPECT_EQ(neighbours.left()[4 * 3], 4u);
  EXPECT_EQ(neighbours.right()[4 * 3], 4u);
  EXPECT_NE(neighbours.left()[5 * 3], 5u);
  const std::vector<std::uint32_t> left(neighbours.left(), neighbours.left() + 150);
  neighbours.findLeft(&even, 3, MatchNeighbours::Self::kKeep);
  EXPECT_EQ(std::vector<std::uint32_t>(neighbours.left(), neighbours.left() + 150), left);
}

TEST(MatchNeighbours, NumbersMatchesByTheirCoordinates) {
  Correspondences m;
  m.add({3, 1}, {9, 9});
  m.add({1, 1}, {8, 8});
  m.add({3, 1}, {9, 9});
  m.add({2, 1}, {7, 7});
  MatchNeighbours neighbours;
  neighbours.assign(m, true);
  ASSERT_EQ(neighbours.size(), 3u);
  EXPECT_EQ(neighbours.left_x, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(neighbours.right_y, (std::vector<float>{8, 7, 9}));
  const std::uint32_t numbers[] = {2, 0, 2, 1};
  for (std::size_t row = 0; row < 4; ++row) EXPECT_EQ(neighbours.ofRow(row), numbers[row]);
  EXPECT_EQ(neighbours.rowOf(0), 1u);
  EXPECT_EQ(neighbours.rowOf(2), 0u);
  neighbours.assign(m, false);
  EXPECT_EQ(neighbours.size(), 4u);
  EXPECT_NE(neighbours.ofRow(0), neighbours.ofRow(2));
  const std::vector<std::uint8_t> mask = {1, 0, 1, 1};
  neighbours.assign(m, true, &mask);
  EXPECT_EQ(neighbours.left_x, (std::vector<float>{2, 3}));
  EXPECT_EQ(neighbours.ofRow(1), MatchNeighbours::kNone);
  EXPECT_EQ(neighbours.ofRow(2), 1u);
}

}  // namespace
}  // namespace corrsel::core
