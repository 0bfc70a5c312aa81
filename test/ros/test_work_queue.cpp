#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <vector>

#include "ros/live/work_queue.h"

namespace corrsel {
namespace {

/// Work on each item lasts until the test ends it.
struct Gate {
  void work(int item) {
    started.push_back(item);
    began.release();
    go.acquire();
  }

  /// A semaphore: C++17 has none.
  class Semaphore {
   public:
    void release() {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++count_;
      changed_.notify_one();
    }
    void acquire() {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return count_ > 0; });
      --count_;
    }

   private:
    std::mutex mutex_;
    std::condition_variable changed_;
    int count_ = 0;
  };

  std::vector<int> started;  ///< read while no work is being done
  Semaphore began, go;
};

TEST(WorkQueue, WorksOnEverythingInOrderWhileItKeepsUp) {
  Gate gate;
  WorkQueue<int> queue(1, [&](int item) { gate.work(item); });
  for (int i = 0; i < 5; ++i) {
    queue.put(i);
    gate.began.acquire();
    gate.go.release();
  }
  queue.stop();
  EXPECT_EQ(gate.started, (std::vector<int>{0, 1, 2, 3, 4}));
  EXPECT_EQ(queue.counts().received, 5u);
  EXPECT_EQ(queue.counts().done, 5u);
  EXPECT_EQ(queue.counts().dropped, 0u);
}

TEST(WorkQueue, DropsWhatHasWaitedLongest) {
  for (const std::size_t capacity : {1u, 3u}) {
    Gate gate;
    WorkQueue<int> queue(capacity, [&](int item) { gate.work(item); });
    queue.put(0);
    gate.began.acquire();  // 0 is being worked on
    for (int i = 1; i <= 10; ++i) queue.put(i);
    for (std::size_t i = 0; i < capacity; ++i) {
      gate.go.release();
      gate.began.acquire();
    }
    gate.go.release();
    queue.stop();
    std::vector<int> expected = {0};
    for (int i = 11 - static_cast<int>(capacity); i <= 10; ++i) expected.push_back(i);
    EXPECT_EQ(gate.started, expected);
    EXPECT_EQ(queue.counts().dropped, 10u - capacity);
    EXPECT_EQ(queue.counts().received, 11u);
  }
}

TEST(WorkQueue, StopWaitsForTheItemInHandAndForgetsTheRest) {
  Gate gate;
  WorkQueue<int> queue(5, [&](int item) { gate.work(item); });
  queue.put(1);
  gate.began.acquire();
  queue.put(2);
  auto stopped = std::async(std::launch::async, [&] { queue.stop(); });
  EXPECT_EQ(stopped.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  gate.go.release();
  stopped.get();
  EXPECT_EQ(gate.started, (std::vector<int>{1}));
  queue.put(3);
  queue.stop();
  EXPECT_EQ(queue.counts().received, 2u);
}

TEST(WorkQueue, ForgetsAnItemOnceItIsDone) {
  std::promise<void> done;
  const auto item = std::make_shared<int>(1);
  WorkQueue<std::shared_ptr<int>> queue(1, [&](const std::shared_ptr<int>&) { done.set_value(); });
  queue.put(item);
  done.get_future().get();
  queue.stop();
  EXPECT_EQ(item.use_count(), 1);
}

TEST(WorkQueue, NoCapacityIsOne) {
  std::atomic<int> sum{0};
  {
    Gate gate;
    WorkQueue<int> queue(0, [&](int item) {
      sum += item;
      gate.work(item);
    });
    queue.put(7);
    gate.began.acquire();
    gate.go.release();
  }
  EXPECT_EQ(sum, 7);
}

}  // namespace
}  // namespace corrsel
