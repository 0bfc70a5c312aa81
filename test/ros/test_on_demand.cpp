#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
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

TEST(OnDemand, StartAdvertisesBeforeItAsksForSubscribers) {
  int subscribers = 0;
  std::string log;
  OnDemand demand(
      true, [&] { return subscribers > 0; }, [&] { log += "start "; }, [&] { log += "stop "; });
  demand.start([&] {
    log += "advertise ";
    subscribers = 1;  // was waiting for the topic
  });
  EXPECT_EQ(log, "advertise start ");
}

TEST(OnDemand, UpdatesWaitWhileItAdvertises) {
  std::atomic<int> subscribers{0};
  std::atomic<bool> advertised{false}, too_early{false};
  OnDemand demand(
      true, [&] { return subscribers > 0; }, [&] { too_early = !advertised; }, [] {});
  std::future<void> update;
  demand.start([&] {
    subscribers = 1;
    update = std::async(std::launch::async, [&] { demand.update(); });
    EXPECT_EQ(update.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
    advertised = true;
  });
  update.get();
  EXPECT_TRUE(demand.running());
  EXPECT_FALSE(too_early);
}

}  // namespace
}  // namespace corrsel
