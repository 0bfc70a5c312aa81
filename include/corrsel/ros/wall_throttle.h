#pragma once

#include <chrono>
#include <mutex>
#include <optional>

namespace corrsel {

/// Lets a warning through now and then. By the steady clock: ROS_*_THROTTLE goes by ROS time and stays silent
/// where that stands still or jumps back.
class WallThrottle {
 public:
  explicit WallThrottle(std::chrono::steady_clock::duration period = std::chrono::seconds(5))
      : period_(period) {}

  /// Whether the period is over; it begins anew with every true. Any thread.
  bool due() {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (last_ && now - *last_ < period_) return false;
    last_ = now;
    return true;
  }

 private:
  const std::chrono::steady_clock::duration period_;
  std::mutex mutex_;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

}  // namespace corrsel
