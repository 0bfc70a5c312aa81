#pragma once

namespace corrsel::core {

/// The source of time for deadlines. Must be safe on several threads at once.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Seconds since an arbitrary fixed moment; never decreases.
  virtual double seconds() = 0;
};

/// Sets the clock of all deadlines of the process. `clock` must outlive them; nullptr selects the steady
/// clock of the system. This is meant for tests, which would otherwise depend on how busy the machine is.
/// @return the clock that was in use before
Clock* setDeadlineClock(Clock* clock);

/// A time limit, counted from construction.
class Deadline {
 public:
  /// @param seconds  0 = no limit
  explicit Deadline(double seconds) : start_(now()), seconds_(seconds), limited_(seconds > 0) {}

  /// Returns whether the time is over. Reads the clock only if there is a limit.
  bool passed() const { return limited_ && elapsed() >= seconds_; }

  /// Seconds since construction.
  double elapsed() const { return now() - start_; }

  /// Moves the deadline forward by `seconds`, so that this time remains for other work.
  void reserve(double seconds) { seconds_ -= seconds; }

 private:
  static double now();

  double start_, seconds_;
  bool limited_;
};

}  // namespace corrsel::core
