#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/parallel.h"

namespace corrsel::core {
namespace {

/// The threads that onThreads() uses, the caller's left out.
std::set<std::thread::id> helpers(std::size_t threads) {
  std::vector<std::thread::id> ids(threads);
  std::atomic<std::size_t> next{0};
  onThreads(threads, [&] { ids[next++] = std::this_thread::get_id(); });
  EXPECT_EQ(next, threads);
  std::set<std::thread::id> result(ids.begin(), ids.end());
  result.erase(std::this_thread::get_id());
  return result;
}

TEST(Parallel, ThreadsAreKept) {
  const std::set<std::thread::id> first = helpers(4);
  EXPECT_EQ(first.size(), 3u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(helpers(4), first);
  for (const std::thread::id& id : helpers(2)) EXPECT_EQ(first.count(id), 1u);
}

TEST(Parallel, NestedCrewsHaveThreadsOfTheirOwn) {
  Crew outer;
  std::thread::id other, inner;
  std::future<void> started = outer.start([&] { other = std::this_thread::get_id(); });
  {
    Crew crew;
    crew.start([&] { inner = std::this_thread::get_id(); }).get();
  }
  started.get();
  EXPECT_NE(inner, other);
  EXPECT_NE(inner, std::this_thread::get_id());
  // Below a crew, too.
  std::atomic<int> sum{0};
  onThreads(3, [&] { onThreads(3, [&] { ++sum; }); });
  EXPECT_EQ(sum, 9);
}

TEST(Parallel, EveryCallerHasThreadsOfItsOwn) {
  const std::set<std::thread::id> mine = helpers(3);
  std::set<std::thread::id> theirs;
  std::thread([&] { theirs = helpers(3); }).join();
  for (const std::thread::id& id : theirs) EXPECT_EQ(mine.count(id), 0u);
}

TEST(Parallel, TheFirstExceptionArrivesOnceAllHaveStopped) {
  for (int thrower = 0; thrower < 2; ++thrower) {  // the caller, then the others
    const std::thread::id caller = std::this_thread::get_id();
    std::atomic<int> running{0};
    const auto work = [&] {
      ++running;
      if ((std::this_thread::get_id() == caller) == (thrower == 0)) {
        --running;
        throw std::runtime_error("this one");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      --running;
    };
    EXPECT_THROW(onThreads(4, work), std::runtime_error);
    EXPECT_EQ(running, 0);
  }
  EXPECT_EQ(helpers(4).size(), 3u) << "threads that saw an exception are of use again";
}

TEST(Parallel, BlocksCoverEverythingOnce) {
  for (int threads : {0, 1, 2, 5}) {
    std::vector<int> hits(1003, 0);
    forEachBlock(hits.size(), 100, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++hits[i];
    });
    EXPECT_EQ(hits, std::vector<int>(hits.size(), 1)) << threads;
  }
  forEachBlock(0, 100, 2, [](std::size_t, std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace corrsel::core
