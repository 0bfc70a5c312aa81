#pragma once

namespace corrsel::core {

/// A condition that does not flicker: it becomes true when a value has been above a limit for some time, and
/// false when it has been below 0.8 times the limit as long.
class Trigger {
 public:
  /// @param hold  s
  Trigger(double limit, double hold) : limit_(limit), hold_(hold) {}

  /// @param time  s, not before that of the last call
  bool update(double time, double value) {
    const bool changes = on_ ? value < kLower * limit_ : value > limit_;
    if (!changes) {
      changing_ = false;
    } else if (!changing_) {
      changing_ = true;
      since_ = time;
    } else if (time - since_ >= hold_ - kRounding) {
      on_ = !on_;
      changing_ = false;
    }
    return on_;
  }

  bool isOn() const { return on_; }

  /// Whether it will change if the value stays.
  bool isChanging() const { return changing_; }

  /// What has not lasted long enough is forgotten.
  void interrupt() { changing_ = false; }

 private:
  static constexpr double kLower = 0.8;
  static constexpr double kRounding = 1e-6;  // of times, s

  double limit_, hold_, since_ = 0;
  bool on_ = false, changing_ = false;
};

}  // namespace corrsel::core
