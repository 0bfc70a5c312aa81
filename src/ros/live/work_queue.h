#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace corrsel {

/// A thread that works on one item after the other, so that callbacks only hand items over. Items wait in a
/// queue. When the queue is full, the item that has waited longest is dropped and counted, so that slow work
/// loses items but latency does not build up.
template <class Item>
class WorkQueue {
 public:
  /// Counts since construction. Items that wait or are in work make up the difference.
  struct Counts {
    std::size_t received = 0, dropped = 0, done = 0;
  };

  /// @param capacity  number of items that may wait beside the one in work; 0 is taken as 1
  /// @param work      called on the thread of the queue, one at a time; must not throw
  WorkQueue(std::size_t capacity, std::function<void(Item)> work)
      : capacity_(std::max<std::size_t>(1, capacity)), work_(std::move(work)), thread_([this] { run(); }) {}

  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;
  ~WorkQueue() { stop(); }

  /// After stop(), does nothing.
  void put(Item item) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (stopped_) return;
      ++counts_.received;
      if (items_.size() == capacity_) {
        items_.pop_front();
        ++counts_.dropped;
      }
      items_.push_back(std::move(item));
    }
    changed_.notify_one();
  }

  /// Waits for the item in work and drops those that wait. Must not be called by `work`.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
      items_.clear();
    }
    changed_.notify_one();
    if (thread_.joinable()) thread_.join();
  }

  Counts counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
  }

 private:
  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopped_ || !items_.empty(); });
      if (stopped_) return;
      {
        Item item = std::move(items_.front());
        items_.pop_front();
        lock.unlock();
        work_(std::move(item));
      }
      lock.lock();
      ++counts_.done;
    }
  }

  const std::size_t capacity_;
  const std::function<void(Item)> work_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  std::deque<Item> items_;
  Counts counts_;
  bool stopped_ = false;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace corrsel
