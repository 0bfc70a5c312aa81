#include "base/progress_meter.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <ostream>

namespace corrsel::core {

std::string durationText(double seconds) {
  if (std::isnan(seconds)) return "--:--";
  const long total = std::lround(seconds);
  char text[32];
  if (total >= 3600) {
    std::snprintf(text, sizeof(text), "%ld:%02ld:%02ld", total / 3600, total / 60 % 60, total % 60);
  } else {
    std::snprintf(text, sizeof(text), "%ld:%02ld", total / 60, total % 60);
  }
  return text;
}

namespace {

std::string numbers(const Progress& p) {
  char text[96];
  if (std::isnan(p.rate)) {
    std::snprintf(text, sizeof(text), "%zu/%zu pairs", p.done, p.total);
    return text;
  }
  std::snprintf(text, sizeof(text), "%zu/%zu pairs, %.2f pairs/s, ", p.done, p.total, p.rate);
  return text + durationText(p.remaining) + " left";
}

}  // namespace

Progress ProgressMeter::at(std::size_t done, const std::string& current) const {
  Progress progress;
  progress.done = done;
  progress.total = total_;
  progress.current = current;
  progress.rate = progress.remaining = std::numeric_limits<double>::quiet_NaN();
  if (done > done_before_) {
    progress.rate = static_cast<double>(done - done_before_) / std::max(watch_.seconds(), 1e-9);
    progress.remaining = static_cast<double>(total_ > done ? total_ - done : 0) / progress.rate;
  }
  return progress;
}

ProgressPrinter::ProgressPrinter(std::ostream& out, bool terminal, double interval)
    : out_(out), terminal_(terminal), interval_(interval) {}

void ProgressPrinter::show(const Progress& progress) {
  if (terminal_) {
    constexpr std::size_t kWidth = 30;
    const std::size_t filled = progress.total == 0 ? 0 : kWidth * progress.done / progress.total;
    out_ << "\r\033[K[" << std::string(filled, '#') << std::string(kWidth - filled, '.') << "] "
         << numbers(progress) << "  " << progress.current << std::flush;
    bar_shown_ = true;
    return;
  }
  const bool last = progress.done == progress.total;
  if (!first_ && !last && since_line_.seconds() < interval_) return;
  first_ = false;
  since_line_.restart();
  out_ << numbers(progress) << (progress.current.empty() ? "" : "  " + progress.current) << std::endl;
}

void ProgressPrinter::finish() {
  if (bar_shown_) out_ << std::endl;
  bar_shown_ = false;
}

}  // namespace corrsel::core
