#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <vector>

#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/ros/conversions.h"
#include "ros/live/callback_thread.h"
#include "ros/live/stamp_cache.h"

namespace corrsel {

/// Publishes a `score` for every `selection` whose `correspondences` and `ground_truth`, with the same stamp,
/// are known. The three may come in any order.
class EvaluatorNodelet : public nodelet::Nodelet {
 public:
  ~EvaluatorNodelet() override { thread_.stop(); }

 private:
  /// What has arrived for one stamp. Several selectors may answer the same correspondences.
  struct Pending {
    CorrespondencesConstPtr correspondences;
    GroundTruthConstPtr truth;
    std::vector<SelectionConstPtr> selections;
  };

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    std::vector<double> tolerances;
    if (pnh.getParam("tolerances", tolerances)) {
      if (!tolerances.empty() && std::all_of(tolerances.begin(), tolerances.end(), isTolerance)) {
        options_.tolerances = tolerances;
      } else {
        NODELET_ERROR("~tolerances is not a list of positive numbers; the default is used");
      }
    }
    const double standard = options_.ground_truth_tolerance;
    pnh.param("ground_truth_tolerance", options_.ground_truth_tolerance, standard);
    if (!isTolerance(options_.ground_truth_tolerance)) {
      NODELET_ERROR_STREAM("~ground_truth_tolerance is not a positive number; " << standard << " px is used");
      options_.ground_truth_tolerance = standard;
    }
    const auto queue = static_cast<std::uint32_t>(std::max(1, pnh.param("subscriber_queue_size", 10)));

    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    publisher_ = nh.advertise<Score>("score", kCapacity);
    subscribers_.push_back(nh.subscribe("ground_truth", queue, &EvaluatorNodelet::onTruth, this));
    subscribers_.push_back(
        nh.subscribe("correspondences", queue, &EvaluatorNodelet::onCorrespondences, this));
    subscribers_.push_back(nh.subscribe("selection", queue, &EvaluatorNodelet::onSelection, this));
  }

  static bool isTolerance(double value) { return std::isfinite(value) && value > 0.0; }

  void onTruth(const GroundTruthConstPtr& msg) {
    Pending& pending = pending_[msg->header.stamp];
    pending.truth = msg;
    score(pending);
  }

  void onCorrespondences(const CorrespondencesConstPtr& msg) {
    Pending& pending = pending_[msg->header.stamp];
    pending.correspondences = msg;
    score(pending);
  }

  void onSelection(const SelectionConstPtr& msg) {
    Pending& pending = pending_[msg->header.stamp];
    pending.selections.push_back(msg);
    score(pending);
  }

  void score(Pending& pending) {
    if (!pending.correspondences || !pending.truth) return;
    for (const SelectionConstPtr& selection : pending.selections) {
      try {
        publish(*pending.correspondences, *pending.truth, *selection);
      } catch (const std::invalid_argument& error) {
        NODELET_WARN_STREAM_THROTTLE(5.0, selection->selector << ": no score: " << error.what());
      }
    }
    pending.selections.clear();
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

  static constexpr std::size_t kCapacity = 100;  ///< stamps remembered

  CallbackThread thread_;  ///< one callback at a time: no locks
  core::EvaluationOptions options_;
  StampCache<Pending> pending_{kCapacity};
  ros::Publisher publisher_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::EvaluatorNodelet, nodelet::Nodelet)
