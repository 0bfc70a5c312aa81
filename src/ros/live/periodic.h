#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace corrsel {

/// Calls a function periodically, in wall time, on a thread of its own. It goes on while the threads of the
/// nodelet manager are all busy, and the destructor waits for a call that is running. ros::WallTimer does
/// not: a callback that has been taken off its queue may begin after the timer is destroyed.
class Periodic {
 public:
  /// @param period  s, > 0; the first call comes after one period
  /// @param call    must neither throw nor destroy this object
  Periodic(double period, std::function<void()> call)
      : period_(period), call_(std::move(call)), thread_([this] { run(); }) {}

  Periodic(const Periodic&) = delete;
  Periodic& operator=(const Periodic&) = delete;

  ~Periodic() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

 private:
  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!changed_.wait_for(lock, period_, [this] { return stopped_; })) {
      lock.unlock();
      call_();
      lock.lock();
    }
  }

  const std::chrono::duration<double> period_;
  const std::function<void()> call_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopped_ = false;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace corrsel
