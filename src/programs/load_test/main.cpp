// Plays two cameras and a consumer against running nodelets; see --help.

#include <ros/ros.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "arguments.h"
#include "base/stopwatch.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/reference/reference_selectors.h"
#include "process_meter.h"
#include "reconfigurer.h"
#include "record.h"
#include "report.h"
#include "sender.h"

namespace corrsel::load_test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kExitOk = 0, kExitProblem = 1, kExitUsage = 2, kExitInterrupted = 130;
constexpr double kSilence = 5.0;  ///< s without a result, after which no more are expected

Clock::duration seconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

/// Cameras and a consumer.
class Player {
 public:
  explicit Player(const Arguments& arguments)
      : sender_(nh_, arguments),
        matches_(nh_.subscribe<Correspondences>(
            "matches", kInbox, [this](const CorrespondencesConstPtr& msg) { record.receive(*msg); })),
        selections_(nh_.subscribe<Selection>(
            "selection", kInbox, [this](const SelectionConstPtr& msg) { record.receive(*msg); })) {}

  /// Sends the next pair, stamped with the current time.
  void send() {
    const ros::WallTime now = ros::WallTime::now();
    const ros::Time stamp(now.sec, now.nsec);
    record.send(stamp);
    sender_.send(stamp);
  }

  /// Names the connections without which no pair can be processed; empty if all exist.
  std::string missing() const {
    std::string text = sender_.missing();
    const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    if (matches_.getNumPublishers() == 0) add("no node publishes " + matches_.getTopic());
    if (selections_.getNumPublishers() == 0) add("no node publishes " + selections_.getTopic());
    return text;
  }

  std::vector<std::string> outputs() const {
    return {matches_.getTopic(), selections_.getTopic(), nh_.resolveName("correspondences")};
  }

  std::string text() const { return sender_.text(); }

  Record record;

 private:
  static constexpr std::uint32_t kInbox = 1000;

  ros::NodeHandle nh_;
  Sender sender_;
  ros::Subscriber matches_, selections_;
};

/// Sends pairs, which do not count, until one has been processed. Throws std::runtime_error if none is in
/// time.
void waitForFirstResult(Player& player, double patience) {
  const core::Stopwatch watch;
  while (ros::ok()) {
    player.send();
    for (int i = 0; i < 10 && ros::ok(); ++i) {
      const Record::Counts counts = player.record.counts();
      if (counts.processed > 0 && counts.selections > 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    if (watch.seconds() < patience) continue;
    const std::string missing = player.missing();
    throw std::runtime_error(
        "no result within " + std::to_string(static_cast<int>(patience)) + " s: " +
        (missing.empty()
             ? "the nodelets receive images, but publish neither matches nor selections; "
               "see the log of the nodelets"
             : missing + "; check that the nodelets are running and that the topics are remapped"));
  }
}

/// Combines readings of the processes into intervals.
class IntervalMeter {
 public:
  IntervalMeter(const ProcessMeter& processes, double length)
      : processes_(processes), length_(length), before_(processes.read()) {}

  /// @param now  s since the start of the test
  void read(double now) {
    const ProcessMeter::Usage usage = processes_.read();
    if (ended.empty()) ended = usage.ended;
    resident_.push_back(usage.resident_mib);
    newest_ = usage;
    end_ = now;
  }

  bool complete() const { return end_ >= length_ * static_cast<double>(intervals.size() + 1); }

  /// Ends the interval with the newest reading.
  void finish() {
    if (resident_.empty() || end_ <= begin_) return;
    Interval interval;
    interval.begin = begin_;
    interval.end = end_;
    const bool measured = !processes_.empty() && newest_.ended.empty();
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    interval.cpu_ratio = measured ? (newest_.cpu_seconds - before_.cpu_seconds) / (end_ - begin_) : kNaN;
    interval.resident_mib = measured ? core::mean(resident_) : kNaN;
    intervals.push_back(interval);
    before_ = newest_;
    begin_ = end_;
    resident_.clear();
  }

  /// Prints the intervals finished since the last time.
  void print(const Record& record) {
    if (printed_ == intervals.size()) return;
    const std::vector<PairRecord> pairs = record.pairs();
    for (; printed_ < intervals.size(); ++printed_) std::cout << intervalLine(intervals[printed_], pairs);
    std::cout << std::flush;
  }

  std::vector<Interval> intervals;
  std::vector<std::string> ended;

 private:
  const ProcessMeter& processes_;
  double length_, begin_ = 0.0, end_ = 0.0;
  std::size_t printed_ = 0;
  ProcessMeter::Usage before_, newest_;
  std::vector<double> resident_;
};

/// Sends pairs at the rate for the length of the test. A camera does not catch up: where sending is late by
/// more than a period, the pairs in between are not sent.
void play(Player& player, const Arguments& arguments, IntervalMeter& meter) {
  const Clock::time_point start = Clock::now();
  const Clock::duration period = seconds(1.0 / arguments.rate);
  const auto elapsed = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  Clock::time_point next = start, next_reading = start + seconds(1.0);
  while (ros::ok() && elapsed() < arguments.seconds) {
    player.send();
    next += period;
    if (Clock::now() > next + period) next = Clock::now();
    if (Clock::now() >= next_reading) {
      next_reading += seconds(1.0);
      meter.read(elapsed());
      meter.print(player.record);  // of the previous reading, whose last results have arrived by now
      if (meter.complete()) meter.finish();
    }
    std::this_thread::sleep_until(std::min(next, start + seconds(arguments.seconds)));
  }
  meter.read(elapsed());
}

/// Waits until the newest pair has been processed, after which no older one will be, or until no more results
/// arrive.
void waitForOutstanding(const Player& player) {
  core::Stopwatch watch;
  std::size_t before = 0;
  while (ros::ok() && watch.seconds() < kSilence) {
    const Record::Counts counts = player.record.counts();
    if (counts.newest_processed) return;
    if (counts.processed + counts.selections != before) watch.restart();
    before = counts.processed + counts.selections;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

int run(const Arguments& arguments) {
  if (!ros::master::check()) {
    throw std::runtime_error("no ROS master at " + ros::master::getURI() + "; start roscore or the nodelets");
  }
  Player player(arguments);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  std::cout << player.text() << " at " << arguments.rate << " Hz for " << arguments.seconds << " s"
            << std::endl;
  player.record.restart();
  waitForFirstResult(player, arguments.wait);
  const ProcessMeter processes(player.outputs());
  std::cout << "processed by " << processes.text() << "\n" << intervalHeader() << std::flush;

  Result result;
  player.record.restart();
  IntervalMeter meter(processes, arguments.interval);
  {
    const Reconfigurer reconfigurer(arguments);
    play(player, arguments, meter);
    result.calls = reconfigurer.calls();
  }
  waitForOutstanding(player);
  meter.finish();
  meter.print(player.record);
  result.pairs = player.record.pairs();
  result.counts = player.record.counts();
  result.intervals = meter.intervals;
  result.ended = meter.ended;
  std::cout << "\n" << summary(result) << std::flush;
  if (!arguments.csv.empty()) writeCsv(arguments.csv, result.pairs);
  const std::vector<std::string> found = problems(result, arguments);
  for (const std::string& problem : found) std::cout << "FAILED: " << problem << std::endl;
  if (!ros::ok()) return kExitInterrupted;
  return found.empty() ? kExitOk : kExitProblem;
}

}  // namespace
}  // namespace corrsel::load_test

int main(int argc, char** argv) {
  using namespace corrsel::load_test;
  corrsel::core::addReferenceSelectors();
  ros::init(argc, argv, "load_test", ros::init_options::AnonymousName);  // takes remappings out of argv
  try {
    const corrsel::ArgumentValues values =
        corrsel::parseCommandLine(argumentTable(), {argv + 1, argv + argc});
    if (values.help) {
      std::cout << corrsel::helpText(argumentTable());
      return kExitOk;
    }
    return run(argumentsOf(values));
  } catch (const std::invalid_argument& error) {
    std::cerr << "load_test: " << error.what() << "\n\n" << corrsel::helpText(argumentTable());
    return kExitUsage;
  } catch (const std::exception& error) {
    std::cerr << "load_test: " << error.what() << "\n";
    return kExitProblem;
  }
}
