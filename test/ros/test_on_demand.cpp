#include <gtest/gtest.h>

#include <future>
#include <string>

#include "ros/live/on_demand.h"

namespace corrsel {
namespace {

TEST(OnDemand, StartsWithTheFirstAndStopsWithTheLast) {
  int subscribers = 0;
  std::string log;
  OnDemand demand(
      true, [&] { return subscribers > 0; }, [&] { log += "start "; }, [&] { log += "stop "; });
  demand.update();
  EXPECT_EQ(log, "");
  EXPECT_FALSE(demand.running());
  for (const int n : {1, 2, 3, 1}) {
    subscribers = n;
    demand.update();
  }
  EXPECT_EQ(log, "start ");
  EXPECT_TRUE(demand.running());
  subscribers = 0;
  demand.update();
  demand.update();
  EXPECT_EQ(log, "start stop ");
  EXPECT_FALSE(demand.running());
  subscribers = 1;
  demand.update();
  EXPECT_EQ(log, "start stop start ");
}

TEST(OnDemand, RunsAlwaysWhereItIsNotLazy) {
  std::string log;
  OnDemand demand(
      false, [] { return false; }, [&] { log += "start "; }, [&] { log += "stop "; });
  demand.update();
  demand.update();
  EXPECT_EQ(log, "start ");
}

TEST(OnDemand, WaitsWhileItIsHeld) {
  int subscribers = 0;
  OnDemand demand(
      true, [&] { return subscribers > 0; }, [] {}, [] {});
  std::future<void> update;
  {
    const auto lock = demand.hold();
    update = std::async(std::launch::async, [&] { demand.update(); });
    EXPECT_EQ(update.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
    subscribers = 1;
  }
  update.get();
  EXPECT_TRUE(demand.running());
}

}  // namespace
}  // namespace corrsel
