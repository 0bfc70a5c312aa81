#include <gtest/gtest.h>

#include "base/deadline.h"
#include "base/stopwatch.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::TickingClock;

TEST(Deadline, PassesWhenItsTimeIsOver) {
  const TickingClock clock(1);
  const Deadline deadline(2.5);      // reads 0
  EXPECT_FALSE(deadline.passed());   // 1
  EXPECT_FALSE(deadline.passed());   // 2
  EXPECT_TRUE(deadline.passed());    // 3
  EXPECT_EQ(deadline.elapsed(), 4);  // 4
  EXPECT_EQ(clock.looks(), 5);
}

TEST(Deadline, PassesEarlierByWhatIsReserved) {
  const TickingClock clock(0);
  Deadline deadline(1000);
  EXPECT_FALSE(deadline.passed());
  deadline.reserve(999);
  EXPECT_FALSE(deadline.passed());
  deadline.reserve(1);
  EXPECT_TRUE(deadline.passed());
}

TEST(Deadline, WithoutALimitNeverPassesAndReadsNoClock) {
  const TickingClock clock(1000);
  Deadline never(0);
  never.reserve(1000);
  const int looks = clock.looks();
  EXPECT_FALSE(never.passed());
  EXPECT_EQ(clock.looks(), looks);
}

TEST(Deadline, TakesTheTimeFromTheSystemAgainAfterATest) {
  { const TickingClock clock(1e9); }
  const Stopwatch watch;
  const Deadline deadline(0.01);
  while (!deadline.passed()) {
  }
  EXPECT_GE(watch.seconds(), 0.01);
  EXPECT_GE(deadline.elapsed(), 0.01);
}

}  // namespace
}  // namespace corrsel::core
