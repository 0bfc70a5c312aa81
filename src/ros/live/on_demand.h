#pragma once

#include <functional>
#include <mutex>
#include <utility>

namespace corrsel {

/// Work that is done only while somebody subscribes to its outcome: starts with the first subscriber, stops
/// with the last.
class OnDemand {
 public:
  /// @param lazy    false: start with the first update() and never stop
  /// @param wanted  whether there are subscribers; called by update()
  OnDemand(bool lazy, std::function<bool()> wanted, std::function<void()> start, std::function<void()> stop)
      : lazy_(lazy), wanted_(std::move(wanted)), start_(std::move(start)), stop_(std::move(stop)) {}

  /// To be called when a subscriber comes or goes; any thread.
  void update() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool wanted = !lazy_ || wanted_();
    if (wanted == running_) return;
    running_ = wanted;
    wanted ? start_() : stop_();
  }

  /// Makes update() wait: to be held while the publishers that `wanted` asks are advertised, since their
  /// first subscriber may come before advertise() returns.
  std::unique_lock<std::mutex> hold() { return std::unique_lock<std::mutex>(mutex_); }

  bool running() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return running_;
  }

 private:
  const bool lazy_;
  const std::function<bool()> wanted_;
  const std::function<void()> start_, stop_;
  mutable std::mutex mutex_;
  bool running_ = false;
};

}  // namespace corrsel
