#pragma once

#include <functional>
#include <mutex>
#include <utility>

namespace corrsel {

/// Work that is done only while somebody subscribes to its output: it starts with the first subscriber and
/// stops with the last one.
class OnDemand {
 public:
  /// @param lazy    false: the work starts with start() and never stops
  /// @param wanted  whether there are subscribers; called by update()
  OnDemand(bool lazy, std::function<bool()> wanted, std::function<void()> start, std::function<void()> stop)
      : lazy_(lazy), wanted_(std::move(wanted)), start_(std::move(start)), stop_(std::move(stop)) {}

  /// Calls `advertise`, which makes the publishers that `wanted` asks, and then update(). Other calls of
  /// update() wait meanwhile, since the first subscriber may come before the publishers are stored.
  template <class Advertise>
  void start(const Advertise& advertise) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      advertise();
    }
    update();
  }

  /// Must be called when a subscriber comes or goes. Any thread.
  void update() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool wanted = !lazy_ || wanted_();
    if (wanted == running_) return;
    running_ = wanted;
    wanted ? start_() : stop_();
  }

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
