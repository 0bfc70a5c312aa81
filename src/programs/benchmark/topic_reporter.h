#pragma once

#include <ros/ros.h>

#include <string>

#include "programs/benchmark/reporter.h"

namespace corrsel {

/// Also publishes ~progress and ~score. Nodes that subscribed to ~score before the start receive every score,
/// as long as they keep up.
class TopicReporter : public Reporter {
 public:
  /// @param node  private namespace
  TopicReporter(bool verbose, const std::string& output_dir, const ros::NodeHandle& node);

  void progress(const core::Progress& progress) override;
  void evaluated(const core::ResultRow& row) override;

  /// Publishes the outcome: "finished", "interrupted" or "failed", with the pairs of the run and not those of
  /// its last stage.
  void finish(const core::RunState& state) override;

 private:
  void publish(const std::string& state);

  std::string output_dir_;
  core::Progress last_;
  ros::NodeHandle node_;
  ros::Publisher progress_publisher_, score_publisher_;
};

}  // namespace corrsel
