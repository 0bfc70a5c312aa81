#pragma once

#include "corrsel/stopwatch.h"

namespace corrsel::core {

/// When to give up. Starts at construction.
class Deadline {
 public:
  /// @param seconds  0 = never
  explicit Deadline(double seconds) : seconds_(seconds) {}
  /// Looks at the clock, unless there is no limit.
  bool passed() const { return seconds_ > 0 && watch_.seconds() >= seconds_; }

 private:
  Stopwatch watch_;
  double seconds_;
};

}  // namespace corrsel::core
