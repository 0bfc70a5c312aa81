#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "ros/live/nodelet_parameters.h"
#include "ros/live/periodic.h"

namespace corrsel {

/// The diagnostics of a live nodelet on /diagnostics: one status about its input ("NODE: input": rate of
/// every input and how long it has been silent), one about its work ("NODE: processing": counts, share of
/// dropped items, seconds per stage, inlier ratio, confidence, what is in use, the last failure). Rates and
/// shares are those of the last seconds, seconds per stage those of the last items. Time is wall time, also
/// under use_sim_time.
class LiveDiagnostics {
 public:
  /// Counts since the start.
  struct Flow {
    bool wanted = true;                                       ///< false: nobody subscribes to the output
    std::vector<std::pair<std::string, std::size_t>> inputs;  ///< name, messages
    std::size_t done = 0, dropped = 0;
  };
  using Stages = std::vector<std::pair<std::string, double>>;  ///< name, s; NaN = not measured

  /// @param pnh   private handle
  /// @param node  name of the node
  /// @param poll  called once a period, on a thread of its own
  LiveDiagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& node,
                  const LiveParameters& parameters, std::function<Flow()> poll);

  /// Sets limits of inlierRatio(), below which the status is WARN or ERROR; 0 = off. Like the next six
  /// members it may be called from any thread.
  void limitInlierRatio(double warn, double error);

  /// One item has been worked on.
  void finished(const Stages& stages);

  /// @param ratio  share of the matches that are selected, 0..1; NaN is left out
  void inlierRatio(double ratio);

  /// @param confidence  of a selection, -log10 units; NaN is left out
  void confidence(double confidence);

  /// Something was lost or late. The status is WARN for some seconds, and the reason stays as the last
  /// failure.
  void failed(const std::string& reason);

  /// What the images suffer from, in words; empty = nothing. The status is WARN for some seconds.
  void imageFaults(const std::string& faults);

  /// Shows a value as it is: {"selector", "lpm:v2"}.
  void set(const std::string& key, const std::string& value);

 private:
  using Clock = std::chrono::steady_clock;
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  /// A limit that warns and one that is an error; 0 = off.
  struct Limits {
    double warn = 0.0, error = 0.0;
  };
  struct Snapshot {
    Clock::time_point time;
    Flow flow;
  };

  void publish();
  void remember(Flow flow);
  void reportInput(Status& status);
  void reportProcessing(Status& status);

  const std::function<Flow()> poll_;
  const Limits drop_ratio_, latency_, silence_;
  std::mutex mutex_;  ///< guards everything from here to updater_
  Limits inlier_ratio_;
  std::deque<Snapshot> snapshots_;                  ///< of the last seconds, newest last
  std::map<std::string, Clock::time_point> heard_;  ///< time of the last message of each input
  std::vector<std::string> stage_order_;
  std::map<std::string, std::deque<double>> stages_;  ///< of the last items, s
  std::deque<double> inlier_ratios_, confidences_;
  std::map<std::string, std::string> values_;
  std::size_t failures_ = 0;
  std::string last_failure_;
  Clock::time_point last_failure_time_;
  std::string image_faults_;
  Clock::time_point image_faults_time_;
  diagnostic_updater::Updater updater_;
  std::unique_ptr<Periodic> timer_;
};

}  // namespace corrsel
