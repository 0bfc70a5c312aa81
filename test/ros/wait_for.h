#pragma once

#include <ros/callback_queue.h>

#include <chrono>
#include <functional>
#include <thread>

namespace corrsel::testing {

using namespace std::chrono_literals;

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Generous: the machine may be busy. Nothing waits that long unless it fails.
constexpr auto kPatience = kSanitized ? 90s : 30s;

/// Calls `wait` until the condition holds. @return false when it did not in time
inline bool waitFor(
    const std::function<bool()>& condition, std::chrono::milliseconds patience = kPatience,
    const std::function<void()>& wait = [] { std::this_thread::sleep_for(5ms); }) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    wait();
  }
  return true;
}

/// Calls the callbacks of a queue until the condition holds. @return false when it did not in time
inline bool waitFor(ros::CallbackQueue& queue, const std::function<bool()>& condition) {
  return waitFor(condition, kPatience, [&queue] { queue.callAvailable(ros::WallDuration(0.002)); });
}

}  // namespace corrsel::testing
