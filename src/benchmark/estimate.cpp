#include "benchmark/estimate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <iterator>
#include <sstream>

#include "base/progress_meter.h"
#include "benchmark/examples.h"

namespace corrsel::core {
namespace {

std::string bytesText(double bytes) {
  constexpr double kStep = 1024;
  const char* const units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  std::size_t unit = 0;
  for (; bytes >= kStep && unit + 1 < std::size(units); ++unit) bytes /= kStep;
  char text[32];
  std::snprintf(text, sizeof(text), unit == 0 || bytes >= 10 ? "%.0f %s" : "%.1f %s", bytes, units[unit]);
  return text;
}

std::string line(const std::string& name, const std::vector<std::string>& cells) {
  constexpr int kNameWidth = 26, kWidth = 13;
  std::ostringstream out;
  out << std::left << std::setw(kNameWidth) << name << std::right;
  for (const std::string& cell : cells) out << " " << std::setw(kWidth) << cell;
  const std::string text = out.str();
  return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
}

std::string line(const std::string& name, const Estimate& estimate) {
  const auto count = [](double value) { return std::to_string(std::llround(value)); };
  return line(name, {std::to_string(estimate.pairs), count(estimate.selections),
                     durationText(estimate.seconds), bytesText(estimate.run_bytes)});
}

/// Pictures of all datasets, as large as those of the trials.
Estimate picturesOf(const std::vector<Trial>& trials, std::size_t pictures) {
  Measured sum;
  for (const Trial& trial : trials) {
    sum.count += trial.pictures.count;
    sum.seconds += trial.pictures.seconds;
    sum.bytes += trial.pictures.bytes;
  }
  const Measured all = sum.scaledTo(pictures);
  Estimate estimate;
  estimate.seconds = all.seconds;
  estimate.run_bytes = all.bytes;
  return estimate;
}

}  // namespace

Measured Measured::scaledTo(std::size_t other) const {
  if (count == 0) return {other, 0, 0};
  const double factor = static_cast<double>(other) / static_cast<double>(count);
  return {other, factor * seconds, factor * bytes};
}

Estimate& Estimate::operator+=(const Estimate& other) {
  pairs += other.pairs;
  selections += other.selections;
  seconds += other.seconds;
  run_bytes += other.run_bytes;
  return *this;
}

Estimate estimateOf(const Trial& trial) {
  const Measured run = trial.run.scaledTo(trial.pairs);
  Estimate estimate;
  estimate.pairs = trial.pairs;
  if (trial.run.count > 0) {
    const double factor = static_cast<double>(trial.pairs) / static_cast<double>(trial.run.count);
    estimate.selections = factor * static_cast<double>(trial.selections);
  }
  estimate.seconds = run.seconds;
  estimate.run_bytes = run.bytes;
  return estimate;
}

std::size_t maxPictures(const std::vector<Trial>& trials, std::size_t selectors) {
  std::size_t pairs = 0;
  for (const Trial& trial : trials) pairs += trial.pairs;
  return selectors * std::min(pairs, kMaxExamples + kExamplesPerDataset * trials.size());
}

std::string estimateTable(const std::vector<Trial>& trials, std::size_t pictures) {
  std::string text = line("", {"pairs", "selections", "time", "folder"});
  for (const Trial& trial : trials) {
    text += trial.run.count > 0 ? line(trial.name, estimateOf(trial))
                                : line(trial.name, {std::to_string(trial.pairs), "?", "?", "?"});
  }
  if (pictures > 0) {
    const Estimate estimate = picturesOf(trials, pictures);
    text += line("at most " + std::to_string(pictures) + " pictures",
                 {"", "", durationText(estimate.seconds), bytesText(estimate.run_bytes)});
  }
  return text + line("sum", sumOf(trials, pictures));
}

Estimate sumOf(const std::vector<Trial>& trials, std::size_t pictures) {
  Estimate sum = picturesOf(trials, pictures);
  for (const Trial& trial : trials) sum += estimateOf(trial);
  return sum;
}

}  // namespace corrsel::core
