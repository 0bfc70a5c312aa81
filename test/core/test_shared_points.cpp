#include <gtest/gtest.h>

#include <vector>

#include "corrsel/random.h"
#include "points/shared_points.h"

namespace corrsel::core {
namespace {

using Numbers = std::vector<std::uint32_t>;

/// The numbers of points, counted anew by their first use, because which ones are used is not a promise.
Numbers renumbered(const SharedPoints& points) {
  Numbers renamed(points.numbers(), 0), result;
  std::uint32_t used = 0;
  for (const std::uint32_t number : points.of) {
    if (number != 0 && renamed.at(number) == 0) renamed[number] = ++used;
    result.push_back(number == 0 ? 0 : renamed[number]);
  }
  return result;
}

TEST(SharedPoints, FindsPointsThatAreEqualAfterRounding) {
  SharedPoints points;
  points.find({1.4F, 7, 0.6F, 1.6F, -0.4F, 0.2F}, {5, 5, 5, 5, 2, 2.4F}, 1);
  EXPECT_EQ(renumbered(points), (Numbers{1, 0, 1, 0, 2, 2}));
  points.find({1.4F, 0.6F}, {5, 5}, 0.1);
  EXPECT_EQ(points.of, (Numbers{0, 0}));
  points.find({}, {}, 1);
  EXPECT_TRUE(points.of.empty());
  EXPECT_EQ(points.numbers(), 1U);
}

TEST(SharedPoints, AgreesWithTheGroupsOfAllPoints) {
  Random random(1);
  for (const double width :
       {3.0, 40.0, 400.0}) {  // crowded, mixed and sparse, with 16-bit and 32-bit numbers
    for (const std::size_t n : {1U, 2U, 500U, 70000U}) {
      std::vector<float> x(n), y(n);
      for (float& value : x) value = static_cast<float>(random.uniform(-width, width));
      for (float& value : y) value = static_cast<float>(random.uniform(-width, width));
      PointGroups all;
      all.number(x, y, 1);
      SharedPoints shared;
      shared.find(x, y, 1);
      std::vector<std::uint32_t> number_of_group(all.sizes.size(), 0), group_of_number(shared.numbers(), 0);
      for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t group = all.of[i], number = shared.of[i];
        ASSERT_LT(number, shared.numbers());
        ASSERT_EQ(number == 0, all.sizes[group] == 1) << "point " << i << " of " << n;
        if (number == 0) continue;
        if (number_of_group[group] == 0) {
          ASSERT_EQ(group_of_number[number], 0U) << "two places have the number " << number;
          number_of_group[group] = number;
          group_of_number[number] = group + 1;
        }
        ASSERT_EQ(number_of_group[group], number) << "point " << i << " of " << n;
      }
    }
  }
}

TEST(SharedPoints, ComparesExactlyWhereCellsAreTooMany) {
  SharedPoints points;
  points.find({1e6F, 1e6F + 1, 1e6F, 0.0F, -0.0F}, {1, 1, 1, 1, 1}, 1e-9);
  EXPECT_EQ(renumbered(points), (Numbers{1, 0, 1, 2, 2}));
}

}  // namespace
}  // namespace corrsel::core
