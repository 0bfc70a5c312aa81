#pragma once

#include <ros/ros.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "benchmark/progress_meter.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/benchmark/runner.h"

namespace corrsel {

/// Prints the progress of the run, and publishes ~progress and ~score where there is a ROS master. Nodes that
/// subscribed to ~score before the start receive every score, as long as they keep up.
class Reporter : public core::RunObserver {
 public:
  /// @param verbose  print every judged selection
  /// @param node     private namespace; none without a ROS master
  Reporter(bool verbose, const std::string& output_dir, const std::optional<ros::NodeHandle>& node);

  void progress(const core::Progress& progress) override;
  void judged(const core::ResultRow& row) override;
  void failed(const core::Failure& failure) override;
  void doubtful(const core::TruthWarning& warning) override;
  void noticed(const core::Remark& remark) override;

  /// Publishes the outcome: "finished", "interrupted" or "failed", with the pairs of the run and not those of
  /// its last stage.
  void finish(const core::RunState& state);

  /// Ends the progress bar's line.
  void endLine() { printer_.finish(); }

 private:
  void publish(const std::string& state);

  core::ProgressPrinter printer_;
  bool verbose_;
  std::string output_dir_;
  std::set<std::string> warnings_;  ///< that were printed
  core::Progress last_;
  std::optional<ros::NodeHandle> node_;
  ros::Publisher progress_publisher_, score_publisher_;
};

}  // namespace corrsel
