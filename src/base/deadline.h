#pragma once

namespace corrsel::core {

/// Where deadlines take the time from. Must be safe on several threads at once.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Seconds since any fixed moment; never less than before.
  virtual double seconds() = 0;
};

/// Lets all deadlines of the process take the time from `clock`, which must outlive them; nullptr stands for
/// the steady clock of the system. For tests, which otherwise would depend on how busy the machine is.
/// @return the clock that was in use before
Clock* setDeadlineClock(Clock* clock);

/// A time limit, counted from construction.
class Deadline {
 public:
  /// @param seconds  0 = no limit
  explicit Deadline(double seconds) : start_(now()), seconds_(seconds), limited_(seconds > 0) {}

  /// Whether the time is over. Reads the clock only where there is a limit.
  bool passed() const { return limited_ && elapsed() >= seconds_; }

  /// Seconds since construction.
  double elapsed() const { return now() - start_; }

  /// Moves the deadline forward by `seconds`, which are then left for other work.
  void reserve(double seconds) { seconds_ -= seconds; }

 private:
  static double now();

  double start_, seconds_;
  bool limited_;
};

}  // namespace corrsel::core
