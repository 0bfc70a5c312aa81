#include "programs/benchmark/topic_reporter.h"

#include <ros/master.h>

#include <cstdint>

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
  constexpr double kMaxWait = 2.0, kStep = 0.01;  // s
  const std::uint32_t known = knownSubscribers(publisher.getTopic());
  const core::Stopwatch watch;
  while (publisher.getNumSubscribers() < known && watch.seconds() < kMaxWait)
    ros::WallDuration(kStep).sleep();
}

}  // namespace

TopicReporter::TopicReporter(bool verbose, const std::string& output_dir, const ros::NodeHandle& node)
    : Reporter(verbose), output_dir_(output_dir), node_(node) {
  progress_publisher_ = node_.advertise<Progress>("progress", 10, true);
  score_publisher_ = node_.advertise<Score>("score", 1000);
  waitForKnownSubscribers(score_publisher_);
}

void TopicReporter::progress(const core::Progress& progress) {
  last_ = progress;
  Reporter::progress(progress);
  publish("running");
}

void TopicReporter::evaluated(const core::ResultRow& row) {
  Reporter::evaluated(row);
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

void TopicReporter::finish(const core::RunState& state) {
  Reporter::finish(state);
  last_.done = state.pairs_done;
  last_.total = state.pairs_total;
  publish(state.interrupted ? "interrupted" : state.complete() ? "finished" : "failed");
}

void TopicReporter::publish(const std::string& state) {
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
