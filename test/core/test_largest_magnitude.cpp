#include <gtest/gtest.h>

#include <vector>

#include "base/largest_magnitude.h"

namespace corrsel::core {
namespace {

TEST(LargestMagnitude, IsFoundAtEveryPlaceWithEitherSign) {
  EXPECT_EQ(largestMagnitude({}), 0.0f);
  for (std::size_t n = 1; n <= 40; ++n) {
    for (std::size_t place = 0; place < n; ++place) {
      std::vector<float> column(n, -1.5f);
      column[place] = 2;
      ASSERT_EQ(largestMagnitude(column), 2.0f) << place << " of " << n;
      column[place] = -2;
      ASSERT_EQ(largestMagnitude(column), 2.0f) << place << " of " << n;
    }
  }
}

}  // namespace
}  // namespace corrsel::core
