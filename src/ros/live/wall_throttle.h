#pragma once

#include <atomic>
#include <chrono>

namespace corrsel {

/// Permits an action at most once per period of steady wall time. ROS_*_THROTTLE uses ROS time, which stands
/// still or jumps with use_sim_time. Thread-safe.
class WallThrottle {
 public:
  explicit WallThrottle(double period_seconds = 5.0)
      : period_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period_seconds))) {}

  /// Whether a period has passed since the last permission; true for the first call.
  bool due() {
    const Clock::rep now = Clock::now().time_since_epoch().count();
    Clock::rep next = next_;
    return now >= next && next_.compare_exchange_strong(next, now + period_.count());
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::duration period_;
  std::atomic<Clock::rep> next_{Clock::time_point::min().time_since_epoch().count()};
};

}  // namespace corrsel
