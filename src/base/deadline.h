#pragma once

#include "base/stopwatch.h"

namespace corrsel::core {

/// When to give up. Starts at construction.
class Deadline {
 public:
  /// @param seconds  0 = never
  explicit Deadline(double seconds) : limited_(seconds > 0), seconds_(seconds) {}

  /// Looks at the clock, unless there is no limit.
  bool passed() const { return limited_ && watch_.seconds() >= seconds_; }

  /// Seconds since construction.
  double elapsed() const { return watch_.seconds(); }

  /// Moves the time to give up forward, so that `seconds` are left for something else.
  void reserve(double seconds) { seconds_ -= seconds; }

 private:
  Stopwatch watch_;
  bool limited_;
  double seconds_;
};

}  // namespace corrsel::core
