#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/ros/conversions.h"
#include "ros/live/callback_thread.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"
#include "ros/live/result_collector.h"
#include "ros/live/wall_throttle.h"

namespace corrsel {

/// Publishes a `score` for every `selection` whose `correspondences` and `ground_truth`, with the same stamp,
/// are known. The three may come in any order.
class EvaluatorNodelet : public nodelet::Nodelet {
 public:
  ~EvaluatorNodelet() override { thread_.stop(); }

 private:
  void onInit() override {
    EvaluatorParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    options_.tolerances = parameters.toleranceList();
    options_.ground_truth_tolerance = parameters.ground_truth_tolerance;
    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    publisher_ = nh.advertise<Score>("score", kCapacity);
    results_.subscribe(nh, static_cast<std::uint32_t>(parameters.subscriber_queue_size));
  }

  void score(ResultCollector::Result& result) {
    if (!result.correspondences || !result.truth) return;
    for (const SelectionConstPtr& selection : result.selections) {
      try {
        publish(*result.correspondences, *result.truth, *selection);
      } catch (const std::invalid_argument& error) {
        if (warning_.due()) NODELET_WARN_STREAM(selection->selector << ": no score: " << error.what());
      }
    }
    result.selections.clear();
  }

  void publish(const Correspondences& correspondences_msg, const GroundTruth& truth_msg,
               const Selection& selection_msg) {
    ScoreLabels labels;
    const core::GroundTruth truth = fromMsg(truth_msg, &labels.pair);
    if (truth.kind == core::TruthKind::kNone) return;
    const core::Correspondences matches = fromMsg(correspondences_msg, &labels.pair);
    const core::Selection selection = fromMsg(selection_msg, nullptr, &labels.selector);
    if (labels.pair.id.pair.empty()) labels.pair.id = {truth_msg.dataset, truth_msg.sequence, truth_msg.pair};
    labels.status = selection.status;
    labels.select_seconds = selection.seconds;
    const core::Evaluation evaluation =
        core::evaluate(truth.kind, core::groundTruthErrors(truth, matches), selection.mask, options_);
    publisher_.publish(boost::make_shared<Score>(toMsg(evaluation, labels)));
  }

  static constexpr std::size_t kCapacity = 100;  ///< stamps that are remembered

  CallbackThread thread_;  ///< one callback at a time, so that no locks are needed; first: see CallbackThread
  core::EvaluationOptions options_;
  WallThrottle warning_;
  ros::Publisher publisher_;
  ResultCollector results_{kCapacity, [this](ResultCollector::Result& result) { score(result); }};
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::EvaluatorNodelet, nodelet::Nodelet)
