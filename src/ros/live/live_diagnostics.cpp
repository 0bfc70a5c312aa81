#include "ros/live/live_diagnostics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "corrsel/evaluation/statistics.h"

namespace corrsel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::size_t kItems = 128;         // whose times and ratios are kept
constexpr std::chrono::seconds kWindow(5);  // over which rates are taken, and a failure is fresh
constexpr char kAge[] = "age";              // the stage that the limits of latency are about

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

void remember(std::deque<double>& values, double value) {
  values.push_back(value);
  if (values.size() > kItems) values.pop_front();
}

double quantileOf(const std::deque<double>& values, double q) {
  return core::quantile({values.begin(), values.end()}, q);
}

std::string text(const char* format, double value) {
  if (!std::isfinite(value)) return "unknown";
  char buffer[64];
  std::snprintf(buffer, sizeof(buffer), format, value);
  return buffer;
}

}  // namespace

LiveDiagnostics::LiveDiagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                 const std::string& node, const LiveParameters& parameters,
                                 std::function<Flow()> poll)
    : poll_(std::move(poll)),
      drop_ratio_{parameters.warn_drop_ratio, parameters.error_drop_ratio},
      latency_{parameters.warn_latency, parameters.error_latency},
      silence_{parameters.warn_silence, parameters.error_silence},
      updater_(nh, pnh, node) {
  updater_.setHardwareID("none");
  updater_.add("input", this, &LiveDiagnostics::reportInput);
  updater_.add("processing", this, &LiveDiagnostics::reportProcessing);
  timer_ = std::make_unique<Periodic>(parameters.diagnostic_period, [this] { publish(); });
}

void LiveDiagnostics::limitInlierRatio(double warn, double error) {
  const std::lock_guard<std::mutex> lock(mutex_);
  inlier_ratio_ = {warn, error};
}

void LiveDiagnostics::finished(const Stages& stages) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [name, value] : stages) {
    if (std::isnan(value)) continue;
    if (stages_.count(name) == 0) stage_order_.push_back(name);
    corrsel::remember(stages_[name], value);
  }
}

void LiveDiagnostics::inlierRatio(double ratio) {
  if (std::isnan(ratio)) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  corrsel::remember(inlier_ratios_, ratio);
}

void LiveDiagnostics::confidence(double confidence) {
  if (std::isnan(confidence)) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  corrsel::remember(confidences_, confidence);
}

void LiveDiagnostics::failed(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++failures_;
  last_failure_ = reason;
  last_failure_time_ = Clock::now();
}

void LiveDiagnostics::imageFaults(const std::string& faults) {
  if (faults.empty()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  image_faults_ = faults;
  image_faults_time_ = Clock::now();
}

void LiveDiagnostics::set(const std::string& key, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  values_[key] = value;
}

void LiveDiagnostics::publish() {
  remember(poll_());
  updater_.force_update();
}

void LiveDiagnostics::remember(Flow flow) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Clock::time_point now = Clock::now();
  for (std::size_t i = 0; i < flow.inputs.size(); ++i) {
    const auto& [name, count] = flow.inputs[i];
    const bool before = !snapshots_.empty() && snapshots_.back().flow.wanted;
    if (!before || snapshots_.back().flow.inputs[i].second != count) heard_[name] = now;
  }
  snapshots_.push_back({now, std::move(flow)});
  while (snapshots_.size() > 2 && now - snapshots_[1].time >= kWindow) snapshots_.pop_front();
}

void LiveDiagnostics::reportInput(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Snapshot& first = snapshots_.front();
  const Snapshot& last = snapshots_.back();
  status.summary(DiagnosticStatus::OK,
                 last.flow.wanted ? "arriving" : "idle: nobody subscribes to the output");
  const double window = seconds(last.time - first.time);
  for (std::size_t i = 0; i < last.flow.inputs.size(); ++i) {
    const auto& [name, count] = last.flow.inputs[i];
    const auto came = static_cast<double>(count - first.flow.inputs[i].second);
    status.add(name + " rate [Hz]", text("%.2f", window > 0 ? came / window : std::nan("")));
    status.add(name + " received", count);
    if (!last.flow.wanted) continue;
    const double silent = seconds(last.time - heard_[name]);
    const bool error = silence_.error > 0 && silent >= silence_.error;
    if (error || (silence_.warn > 0 && silent >= silence_.warn)) {
      status.mergeSummary(error ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN,
                          "no " + name + " for " + text("%.1f", silent) + " s");
    }
  }
}

void LiveDiagnostics::reportProcessing(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Flow& first = snapshots_.front().flow;
  const Flow& last = snapshots_.back().flow;
  status.summary(DiagnosticStatus::OK, "keeping up");
  const auto compare = [&status](const Limits& limits, double value, bool above, const std::string& what) {
    const auto beyond = [&](double limit) { return limit > 0 && (above ? value > limit : value < limit); };
    if (!beyond(limits.warn) && !beyond(limits.error)) return;  // also where the value is unknown
    status.mergeSummary(beyond(limits.error) ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN, what);
  };

  status.add("processed", last.done);
  status.add("dropped", last.dropped);
  const auto dropped = static_cast<double>(last.dropped - first.dropped);
  const double items = dropped + static_cast<double>(last.done - first.done);
  const double drop_ratio = items > 0 ? dropped / items : std::nan("");
  status.add("drop ratio", text("%.3f", drop_ratio));
  compare(drop_ratio_, drop_ratio, true, "drops " + text("%.0f", 100 * drop_ratio) + " % of the items");

  for (const std::string& name : stage_order_) {
    const std::deque<double>& values = stages_[name];
    status.add("p50 " + name + " [s]", text("%.5f", quantileOf(values, 0.5)));
    status.add("p95 " + name + " [s]", text("%.5f", quantileOf(values, 0.95)));
    if (name == kAge) {
      const double age = quantileOf(values, 0.95);
      compare(latency_, age, true, "results are " + text("%.3f", age) + " s old");
    }
  }
  if (!inlier_ratios_.empty()) {
    const double ratio = core::mean({inlier_ratios_.begin(), inlier_ratios_.end()});
    status.add("inlier ratio", text("%.3f", ratio));
    compare(inlier_ratio_, ratio, false,
            "only " + text("%.1f", 100 * ratio) + " % of the matches are selected");
  }
  if (!confidences_.empty()) status.add("p50 confidence", text("%.1f", quantileOf(confidences_, 0.5)));
  for (const auto& [key, value] : values_) status.add(key, value);
  status.add("failures", failures_);
  status.add("last failure", last_failure_.empty() ? "none" : last_failure_);
  if (failures_ > 0 && Clock::now() - last_failure_time_ < kWindow) {
    status.mergeSummary(DiagnosticStatus::WARN, last_failure_);
  }
  if (!image_faults_.empty() && Clock::now() - image_faults_time_ < kWindow) {
    status.mergeSummary(DiagnosticStatus::WARN, image_faults_);
  }
}

}  // namespace corrsel
