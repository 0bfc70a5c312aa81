#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>

#include "ros/live/periodic.h"

namespace corrsel {
namespace {

using namespace std::chrono_literals;

TEST(Periodic, CallsAgainAndAgain) {
  std::promise<void> third;
  std::atomic<int> calls{0};
  const Periodic periodic(0.001, [&] {
    if (++calls == 3) third.set_value();
  });
  EXPECT_EQ(third.get_future().wait_for(20s), std::future_status::ready);
}

TEST(Periodic, EndsAtOnceWhereNothingIsRunning) {
  const auto begin = std::chrono::steady_clock::now();
  {
    const Periodic periodic(3600.0, [] {});
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 600s);
}

TEST(Periodic, WaitsForACallThatIsRunning) {
  std::promise<void> began, go;
  std::atomic<bool> done{false};
  bool first = true;
  auto periodic = std::make_unique<Periodic>(0.001, [&] {
    if (!first) return;
    first = false;
    began.set_value();
    go.get_future().wait();
    done = true;
  });
  began.get_future().wait();
  auto destroyed = std::async(std::launch::async, [&] { periodic.reset(); });
  EXPECT_EQ(destroyed.wait_for(50ms), std::future_status::timeout);
  EXPECT_FALSE(done);
  go.set_value();
  destroyed.get();
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace corrsel
