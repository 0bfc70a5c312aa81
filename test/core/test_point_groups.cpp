#include <gtest/gtest.h>

#include "points/point_groups.h"

namespace corrsel::core {
namespace {

TEST(PointGroups, NumbersPointsThatAreEqualAfterRounding) {
  PointGroups groups;
  groups.number({1.4F, 0.6F, 1.6F, -0.4F, 1.0F, 0.2F}, {5, 5, 5, 2, 5.4F, 2.4F}, 1);
  EXPECT_EQ(groups.of, (std::vector<std::uint32_t>{0, 0, 1, 2, 0, 2}));
  EXPECT_EQ(groups.sizes, (std::vector<std::uint32_t>{3, 1, 2}));
  groups.number({1.4F, 0.6F}, {5, 5}, 0.1);
  EXPECT_EQ(groups.of, (std::vector<std::uint32_t>{0, 1}));
  groups.number({}, {}, 1);
  EXPECT_TRUE(groups.of.empty() && groups.sizes.empty());
}

TEST(PointGroups, RoundsDownToTheCellsOfAGrid) {
  PointGroups groups;
  groups.number({0, 7.9F, 8, -0.1F, 7}, {0, 7.9F, 0, 0, -8}, 8, PointGroups::Rounding::kDown);
  EXPECT_EQ(groups.of, (std::vector<std::uint32_t>{0, 0, 1, 2, 3}));
}

TEST(PointGroups, ComparesExactlyWhereCellsAreTooMany) {
  PointGroups groups;
  groups.number({1e6F, 1e6F + 1, 1e6F, 0.0F, -0.0F}, {1, 1, 1, 1, 1}, 1e-9);
  EXPECT_EQ(groups.of, (std::vector<std::uint32_t>{0, 1, 0, 2, 2}));
}

}  // namespace
}  // namespace corrsel::core
