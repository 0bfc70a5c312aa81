#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "arguments.h"
#include "corrsel/random.h"

namespace corrsel::load_test {

/// Changes a random parameter of the nodelets at regular intervals, on a separate thread.
class Reconfigurer {
 public:
  /// Starts the thread if the arguments ask for changes.
  explicit Reconfigurer(const Arguments& arguments);
  ~Reconfigurer();
  Reconfigurer(const Reconfigurer&) = delete;
  Reconfigurer& operator=(const Reconfigurer&) = delete;

  struct Calls {
    std::vector<double> seconds;  ///< until the reply, of the calls that succeeded
    std::size_t failed = 0;       ///< calls without a reply
    std::size_t not_taken = 0;    ///< calls after which another value is in force
  };
  Calls calls() const;

 private:
  void run();
  void change();

  Arguments arguments_;
  core::Random random_;
  mutable std::mutex mutex_;
  Calls calls_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace corrsel::load_test
