#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::testing {

/// While it exists, runs of HeldSelector do not end. There is one at a time.
class Hold {
 public:
  Hold() { set(true); }
  ~Hold() { set(false); }
  Hold(const Hold&) = delete;
  Hold& operator=(const Hold&) = delete;

  /// @return whether a run has begun within a minute
  bool waitForRun() const {
    std::unique_lock<std::mutex> lock(state().mutex);
    return state().changed.wait_for(lock, kPatience, [] { return state().running; });
  }

  bool running() const {
    const std::lock_guard<std::mutex> lock(state().mutex);
    return state().running;
  }

  /// The run: it ends after a minute at the latest, so that a test can fail.
  static void run() {
    std::unique_lock<std::mutex> lock(state().mutex);
    state().running = true;
    state().changed.notify_all();
    state().changed.wait_for(lock, kPatience, [] { return !state().held; });
    state().running = false;
  }

 private:
  static constexpr std::chrono::seconds kPatience{60};

  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool held = false, running = false;
  };

  static State& state() {
    static State only;
    return only;
  }

  static void set(bool held) {
    const std::lock_guard<std::mutex> lock(state().mutex);
    state().held = held;
    state().changed.notify_all();
  }
};

/// Selects every match, but not before the test lets it.
class HeldSelector : public core::SelectorWithOptions<core::NoOptions> {
 public:
  static constexpr char kName[] = "held";

  std::string name() const override { return kName; }

 protected:
  void run(const core::Correspondences&, core::Workspace&, core::Selection& result) const override {
    Hold::run();
    result.mask.assign(result.mask.size(), 1);
  }
};

}  // namespace corrsel::testing
