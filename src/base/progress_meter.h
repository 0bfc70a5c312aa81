#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>

#include "base/stopwatch.h"
#include "corrsel/progress.h"

namespace corrsel::core {

/// "4:05" (min:s) or "1:04:05" (h:min:s); "--:--" for NaN.
std::string durationText(double seconds);

/// Computes rate and remaining time from the pairs done in this session.
class ProgressMeter {
 public:
  /// @param done_before  pairs that an earlier session finished
  ProgressMeter(std::size_t total, std::size_t done_before) : total_(total), done_before_(done_before) {}

  Progress at(std::size_t done, const std::string& current) const;

 private:
  std::size_t total_, done_before_;
  Stopwatch watch_;
};

/// Shows progress: on a terminal a bar that is redrawn in place, elsewhere a line every few seconds.
class ProgressPrinter {
 public:
  /// @param interval  smallest time between two lines where `out` is not a terminal, s
  ProgressPrinter(std::ostream& out, bool terminal, double interval = 5.0);

  void show(const Progress& progress);

  /// Ends the line of the bar, so that later output starts on a new line.
  void finish();

 private:
  std::ostream& out_;
  bool terminal_, bar_shown_ = false, first_ = true;
  double interval_;
  Stopwatch since_line_;
};

}  // namespace corrsel::core
