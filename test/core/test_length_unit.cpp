#include <gtest/gtest.h>

#include "corrsel/correspondences.h"
#include "points/length_unit.h"

namespace corrsel::core {
namespace {

TEST(LengthUnit, IsAShareOfTheDiagonal) {
  EXPECT_DOUBLE_EQ(lengthUnit({800, 600}, {}, {}), 0.8);
  EXPECT_DOUBLE_EQ(lengthUnit({4000, 3000}, {}, {}), 4);
}

TEST(LengthUnit, TakesTheExtentOfThePointsWhereTheSizeIsUnknown) {
  EXPECT_DOUBLE_EQ(lengthUnit({}, {10, 310, 50}, {20, 100, 420}), 0.4);
}

TEST(LengthUnit, IsPositiveForPointsAtOnePlace) {
  EXPECT_GT(lengthUnit({}, {}, {}), 0);
  EXPECT_GT(lengthUnit({}, {5, 5}, {7, 7}), 0);
}

TEST(LengthUnits, HasOneUnitForEachImage) {
  Correspondences m;
  m.left_size = {800, 600};
  m.right_size = {400, 300};
  const LengthUnits units = LengthUnits::of(m);
  EXPECT_DOUBLE_EQ(units.left, 0.8);
  EXPECT_DOUBLE_EQ(units.right, 0.4);
}

}  // namespace
}  // namespace corrsel::core
