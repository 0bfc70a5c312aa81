#include <gtest/gtest.h>

#include <limits>

#include "base/saturated.h"

namespace corrsel::core {
namespace {

TEST(Saturated, TruncatesWhatFits) {
  EXPECT_EQ(saturated(2.9F), 2);
  EXPECT_EQ(saturated(-2.9F), -2);
  EXPECT_EQ(saturated(2147483520.0F), 2147483520);
  EXPECT_EQ(saturated(-2147483520.0F), -2147483520);
}

TEST(Saturated, LimitsWhatDoesNotFit) {
  const std::int32_t least = std::numeric_limits<std::int32_t>::min();
  for (const float huge : {2147483648.0F, 1e30F, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(saturated(huge), 2147483520) << huge;
    EXPECT_EQ(saturated(-huge), least) << huge;
  }
  EXPECT_EQ(saturated(std::numeric_limits<float>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace corrsel::core
