#include "report.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/core/utility.hpp>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/evaluation/statistics.h"

namespace corrsel::load_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMilliseconds = 1000.0;

double largest(const std::vector<double>& values) {
  return values.empty() ? kNaN : *std::max_element(values.begin(), values.end());
}

/// Right-aligned; "-" for NaN.
std::string cell(double value, int width, int digits) {
  return std::isnan(value) ? cv::format("%*s", width, "-") : cv::format("%*.*f", width, digits, value);
}

std::string quantiles(const char* name, const std::vector<double>& values, double scale, int digits) {
  const auto scaled = [scale](double value) { return value * scale; };
  return cv::format("  %-26s", name) + cell(scaled(core::quantile(values, 0.5)), 9, digits) +
         cell(scaled(core::quantile(values, 0.95)), 9, digits) + cell(scaled(largest(values)), 9, digits) +
         "\n";
}

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? kNaN : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

/// What the stages leave of the time from the stamp to the selection.
double rest(const PairRecord& pair) {
  double sum = 0.0;
  for (const double seconds : pair.stages) sum += std::isnan(seconds) ? 0.0 : seconds;
  return pair.selection_latency - sum;
}

std::string stageTable(const std::vector<PairRecord>& pairs) {
  std::vector<double> latency, selection_latency, rests, putative, selected;
  std::array<std::vector<double>, kStages.size()> stages;
  for (const PairRecord& pair : pairs) {
    if (pair.processed()) latency.push_back(pair.latency);
    if (!pair.selected()) continue;
    selection_latency.push_back(pair.selection_latency);
    rests.push_back(rest(pair));
    putative.push_back(static_cast<double>(pair.n_input));
    selected.push_back(static_cast<double>(pair.n_selected));
    for (std::size_t i = 0; i < kStages.size(); ++i) {
      if (!std::isnan(pair.stages[i])) stages[i].push_back(pair.stages[i]);
    }
  }
  std::string text = cv::format("  %-26s%9s%9s%9s\n", "", "p50", "p95", "max");
  text += quantiles("stamp to matches, ms", latency, kMilliseconds, 1);
  text += quantiles("stamp to selection, ms", selection_latency, kMilliseconds, 1);
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    text += quantiles((std::string("  ") + kStages[i]).c_str(), stages[i], kMilliseconds, 2);
  }
  const bool overlap = core::quantile(rests, 0.5) < 0;  // detect and describe add up two threads' times
  text += quantiles(overlap ? "  less: side by side" : "  rest (transport)", rests, kMilliseconds, 2);
  text += quantiles("putative matches", putative, 1.0, 0);
  text += quantiles("selected matches", selected, 1.0, 0);
  return text;
}

}  // namespace

std::string intervalHeader() {
  return "       s     sent processed   p50 ms    p95 ms    max ms    CPU %  memory MiB\n";
}

std::string intervalLine(const Interval& interval, const std::vector<PairRecord>& pairs) {
  std::size_t sent = 0;
  std::vector<double> latency;
  for (const PairRecord& pair : pairs) {
    if (pair.sent < interval.begin || pair.sent >= interval.end) continue;
    ++sent;
    if (pair.processed()) latency.push_back(pair.latency * kMilliseconds);
  }
  return cell(interval.end, 8, 0) + cv::format("%9zu%9zu", sent, latency.size()) +
         cell(core::quantile(latency, 0.5), 10, 1) + cell(core::quantile(latency, 0.95), 10, 1) +
         cell(largest(latency), 10, 1) + cell(interval.cpu_ratio * 100.0, 9, 1) +
         cell(interval.resident_mib, 12, 1) + "\n";
}

double memoryGrowth(const std::vector<Interval>& intervals) {
  if (intervals.size() < 2) return kNaN;
  const double early = intervals.back().end / 6.0;
  const auto reference = std::find_if(intervals.begin(), intervals.end(),
                                      [early](const Interval& interval) { return interval.end >= early; });
  return intervals.back().resident_mib / reference->resident_mib - 1.0;
}

std::string summary(const Result& result) {
  const Record::Counts& counts = result.counts;
  const std::size_t dropped = counts.sent - counts.processed;
  const double duration = result.pairs.size() < 2 ? kNaN : result.pairs.back().sent - result.pairs[0].sent;
  std::string text = cv::format("pairs sent %zu", counts.sent);
  if (duration > 0.0) {
    text += cv::format(" (%.2f Hz)", static_cast<double>(counts.sent - 1) / duration);
  }
  text += cv::format(", processed %zu (%.2f %%), dropped %zu (%.2f %%), selections %zu\n", counts.processed,
                     percent(counts.processed, counts.sent), dropped, percent(dropped, counts.sent),
                     counts.selections);
  text += cv::format("results that came twice %zu, out of order %zu, for pairs never sent %zu\n",
                     counts.duplicates, counts.out_of_order, counts.unknown);
  text += stageTable(result.pairs);
  const Reconfigurer::Calls& calls = result.calls;
  if (!calls.seconds.empty() || calls.failed > 0) {
    text += cv::format("parameters changed %zu times (p95 %.1f ms, max %.1f ms until the reply), ",
                       calls.seconds.size(), core::quantile(calls.seconds, 0.95) * kMilliseconds,
                       largest(calls.seconds) * kMilliseconds);
    text += cv::format("%zu without reply, %zu without effect\n", calls.failed, calls.not_taken);
  }
  const double growth = memoryGrowth(result.intervals);
  if (!std::isnan(growth)) text += cv::format("memory %+.1f %% since one sixth of the test\n", growth * 100);
  return text;
}

std::vector<std::string> problems(const Result& result, const Arguments& arguments) {
  std::vector<std::string> texts;
  const Record::Counts& counts = result.counts;
  const double drop_ratio =
      counts.sent == 0 ? 0.0 : 1.0 - static_cast<double>(counts.processed) / static_cast<double>(counts.sent);
  if (counts.processed == 0) texts.push_back("no pair was processed");
  if (drop_ratio > arguments.max_drop_ratio) {
    texts.push_back(
        cv::format("drop ratio %.4f is above --max-drop-ratio %g", drop_ratio, arguments.max_drop_ratio));
  }
  const double growth = memoryGrowth(result.intervals);
  if (std::isfinite(arguments.max_memory_growth) && !(growth <= arguments.max_memory_growth)) {
    texts.push_back(std::isnan(growth)
                        ? "memory growth is not known: it needs two intervals, see --interval, "
                          "and nodelets on this machine"
                        : cv::format("memory growth %.4f is above --max-memory-growth %g", growth,
                                     arguments.max_memory_growth));
  }
  if (counts.duplicates > 0) texts.push_back(cv::format("%zu results came twice", counts.duplicates));
  if (counts.out_of_order > 0) texts.push_back(cv::format("%zu results out of order", counts.out_of_order));
  if (counts.unknown > 0) texts.push_back(cv::format("%zu results for pairs never sent", counts.unknown));
  if (result.calls.failed > 0) {
    texts.push_back(cv::format("%zu changes of parameters got no reply", result.calls.failed));
  }
  if (result.calls.not_taken > 0) {
    texts.push_back(cv::format("%zu changes of parameters had no effect", result.calls.not_taken));
  }
  for (const std::string& node : result.ended) texts.push_back("the process of " + node + " ended");
  return texts;
}

void writeCsv(const std::string& path, const std::vector<PairRecord>& pairs) {
  std::ofstream file(path);
  file << "stamp,sent_s,matches_latency_s,selection_latency_s";
  for (const char* const stage : kStages) file << ',' << stage << "_s";
  file << ",selector,status,n_input,n_selected\n";
  for (const PairRecord& pair : pairs) {
    std::vector<std::string> fields = {cv::format("%u.%09u", pair.stamp.sec, pair.stamp.nsec),
                                       core::formatNumber(pair.sent), core::formatNumber(pair.latency),
                                       core::formatNumber(pair.selection_latency)};
    for (const double seconds : pair.stages) fields.push_back(core::formatNumber(seconds));
    const bool selected = pair.selected();
    fields.push_back(pair.selector);
    fields.push_back(selected ? std::to_string(pair.status) : "");
    fields.push_back(selected ? std::to_string(pair.n_input) : "");
    fields.push_back(selected ? std::to_string(pair.n_selected) : "");
    file << core::csvLine(fields) << '\n';
  }
  file.flush();
  if (!file)
    throw std::runtime_error("cannot write " + path + ": is the folder there, and the disk not full?");
}

}  // namespace corrsel::load_test
