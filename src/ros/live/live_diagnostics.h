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

#include "ros/live/periodic.h"

namespace corrsel {

/// What a live nodelet tells about itself on /diagnostics: one status about what comes in ("NODE: input":
/// rate of every input, how long it has been silent), one about the work ("NODE: processing": counts, share
/// of dropped items, seconds per stage, inlier ratio, what is in use, the last failure). Rates and shares are
/// those of the last seconds, seconds per stage those of the last answers. Time is wall time, also under
/// use_sim_time.
///
/// Private parameters, 0 = off: `warn_drop_ratio` (0.2), `error_drop_ratio` (0.9), `warn_latency` and
/// `error_latency` (0; s, 95th percentile of the age of the left image when it is answered),
/// `warn_inlier_ratio` (0.1), `error_inlier_ratio` (0), `warn_silence` (2 s), `error_silence` (10 s);
/// `diagnostic_period` (1 s).
class LiveDiagnostics {
 public:
  /// What has happened since the start.
  struct Flow {
    bool wanted = true;                                       ///< false: nobody subscribes to the outcome
    std::vector<std::pair<std::string, std::size_t>> inputs;  ///< name, how many came
    std::size_t done = 0, dropped = 0;
  };
  using Stages = std::vector<std::pair<std::string, double>>;  ///< name, s; NaN = not measured

  /// @param pnh   private handle
  /// @param node  name of the node
  /// @param poll  called once a period, on a thread of its own
  LiveDiagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& node,
                  std::function<Flow()> poll);

  /// One item has been answered. Like the next three callable from any thread.
  void answered(const Stages& stages);

  /// @param ratio  of the matches, the selected ones, 0..1; NaN is left out
  void inlierRatio(double ratio);

  /// Something was lost or late: shown as a warning for some seconds, and as the last failure from then on.
  void failed(const std::string& reason);

  /// Shown as it is: {"selector", "lpm:v2"}.
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
  Limits drop_ratio_, latency_, inlier_ratio_, silence_;
  std::mutex mutex_;                                ///< guards what follows up to updater_
  std::deque<Snapshot> snapshots_;                  ///< of the last seconds, newest last
  std::map<std::string, Clock::time_point> heard_;  ///< when each input last was
  std::vector<std::string> stage_order_;
  std::map<std::string, std::deque<double>> stages_;  ///< of the last answers, s
  std::deque<double> inlier_ratios_;
  std::map<std::string, std::string> values_;
  std::size_t failures_ = 0;
  std::string last_failure_;
  Clock::time_point last_failure_time_;
  diagnostic_updater::Updater updater_;
  std::unique_ptr<Periodic> timer_;
};

}  // namespace corrsel
