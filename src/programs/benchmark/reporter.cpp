#include "programs/benchmark/reporter.h"

#include <ros/master.h>
#include <unistd.h>

#include <cstdint>
#include <iostream>

#include "base/stopwatch.h"
#include "corrsel/Progress.h"
#include "corrsel/Score.h"
#include "corrsel/ros/conversions.h"

namespace corrsel {
namespace {

/// How many nodes the master lists as subscribers of a topic.
std::uint32_t knownSubscribers(const std::string& topic) {
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return 0;
  XmlRpc::XmlRpcValue& subscribers = state[1];  // pairs of a topic and a list of nodes
  for (int i = 0; i < subscribers.size(); ++i) {
    if (static_cast<std::string>(subscribers[i][0]) == topic)
      return static_cast<std::uint32_t>(subscribers[i][1].size());
  }
  return 0;
}

/// Waits until the nodes that subscribed before this one started are connected: a short run would end before,
/// and its messages would be lost. A node that the master lists but that is gone costs the whole time.
void waitForKnownSubscribers(const ros::Publisher& publisher) {
  constexpr double kLongest = 2.0, kStep = 0.01;  // s
  const std::uint32_t known = knownSubscribers(publisher.getTopic());
  const core::Stopwatch watch;
  while (publisher.getNumSubscribers() < known && watch.seconds() < kLongest)
    ros::WallDuration(kStep).sleep();
}

}  // namespace

Reporter::Reporter(bool verbose, const std::string& output_dir, const std::optional<ros::NodeHandle>& node)
    : printer_(std::cout, isatty(STDOUT_FILENO) != 0),
      verbose_(verbose),
      output_dir_(output_dir),
      node_(node) {
  if (!node_) return;
  progress_publisher_ = node_->advertise<Progress>("progress", 10, true);
  score_publisher_ = node_->advertise<Score>("score", 1000);
  waitForKnownSubscribers(score_publisher_);
}

void Reporter::progress(const core::Progress& progress) {
  last_ = progress;
  printer_.show(progress);
  publish("running");
}

void Reporter::judged(const core::ResultRow& row) {
  if (verbose_) {
    printer_.finish();
    std::cout << row.id.text() << " " << row.features << " " << row.preselection << " " << row.selector
              << ": " << row.n_selected << " of " << row.n_putative << " selected, " << toString(row.status)
              << std::endl;
  }
  if (!node_) return;
  core::Evaluation evaluation;
  evaluation.n_putative = row.n_putative;
  evaluation.n_ground_truth = row.n_ground_truth;
  evaluation.n_selected = row.n_selected;
  evaluation.metrics = row.metrics;
  ScoreLabels labels;
  labels.pair.header.stamp = ros::Time(ros::WallTime::now().toSec());
  labels.pair.id = row.id;
  labels.pair.features = row.features;
  labels.preselection = row.preselection;
  labels.selector = row.selector;
  labels.status = row.status;
  labels.select_seconds = row.select_seconds;
  score_publisher_.publish(toMsg(evaluation, labels));
}

void Reporter::failed(const core::Failure& failure) {
  printer_.finish();
  std::cerr << "failed (" << failure.stage
            << "): " << (failure.id.dataset.empty() ? "" : failure.id.text() + ": ") << failure.error
            << std::endl;
}

void Reporter::doubtful(const core::TruthWarning& warning) {
  const std::string text = warning.text();
  if (!warnings_.insert(text).second) return;
  printer_.finish();
  std::cerr << "warning: doubtful ground truth: " << text << std::endl;
}

void Reporter::noticed(const core::Remark& remark) {
  printer_.finish();
  std::cout << "note: " << remark.sentence() << std::endl;
}

void Reporter::finish(const core::RunState& state) {
  printer_.finish();
  last_.done = state.pairs_done;
  last_.total = state.pairs_total;
  publish(state.interrupted ? "interrupted" : state.complete() ? "finished" : "failed");
}

void Reporter::publish(const std::string& state) {
  if (!node_) return;
  Progress message;
  message.header.stamp = ros::Time(ros::WallTime::now().toSec());
  message.state = state;
  message.current = last_.current;
  message.pairs_done = static_cast<std::uint32_t>(last_.done);
  message.pairs_total = static_cast<std::uint32_t>(last_.total);
  message.rate = last_.rate;
  message.remaining_seconds = last_.remaining;
  message.output_dir = output_dir_;
  progress_publisher_.publish(message);
}

}  // namespace corrsel
