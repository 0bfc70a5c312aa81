#include <corrsel/SelectorConfig.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nodelet/nodelet.h>
#include <ros/param.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/Correspondences.h"
#include "corrsel/RelativePose.h"
#include "corrsel/Selection.h"
#include "corrsel/motion_guess.h"
#include "corrsel/ros/selector_plugins.h"
#include "ros/live/live_selector.h"
#include "ros/live/live_source.h"
#include "ros/live/live_stage.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"

namespace corrsel {

/// Publishes, for every message on `correspondences`, the matches that the chosen selector keeps (`matches`),
/// its decision (`selection`), and, if it estimates one, the pose between the images (`relative_pose`,
/// `pose`).
class SelectorNodelet : public nodelet::Nodelet {
  struct Item {
    CorrespondencesConstPtr message;
    core::Stopwatch waiting;
  };
  using Stage = LiveStage<Item, SelectorConfig>;

  void onInit() override {
    enableSelectorPlugins();
    SelectorParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    for (const std::string& text : unreadParameters(ownParameters())) NODELET_ERROR_STREAM(text);
    selector_ = std::make_unique<LiveSelector>(parameters.presets_in_force);
    Stage::Parts parts;
    parts.open = [&](const ros::NodeHandle& nh, Stage::Put put) {
      return std::make_unique<MessageSource<Correspondences>>(
          nh, "correspondences", static_cast<std::uint32_t>(parameters.subscriber_queue_size),
          [put = std::move(put)](const CorrespondencesConstPtr& message) {
            put({message, core::Stopwatch()});
          });
    };
    parts.work = [this](const Item& item) { select(item); };
    parts.configure = [this](SelectorConfig& config, std::uint32_t level) { configure(config, level); };
    stage_ = std::make_unique<Stage>(getNodeHandle(), getPrivateNodeHandle(), getName(), parameters,
                                     std::move(parts));
    stage_->diagnostics().limitInlierRatio(parameters.warn_inlier_ratio, parameters.error_inlier_ratio);
    stage_->start({Stage::output<Correspondences>("matches"), Stage::output<Selection>("selection"),
                   Stage::output<RelativePose>("relative_pose"),
                   Stage::output<geometry_msgs::PoseWithCovarianceStamped>("pose")});
  }

  /// The parameters that are set below the nodelet's namespace.
  std::vector<std::string> ownParameters() {
    const std::string prefix = getPrivateNodeHandle().getNamespace() + "/";
    std::vector<std::string> all, own;
    ros::param::getParamNames(all);
    for (const std::string& name : all) {
      if (name.compare(0, prefix.size(), prefix) == 0) own.push_back(name.substr(prefix.size()));
    }
    return own;
  }

  void select(const Item& item) {
    const LiveSelector::Result result = selector_->select(*item.message, item.waiting.seconds());
    Selection& selection = *result.selection;
    const core::Stopwatch watch;
    stage_->publish("matches", result.matches);
    if (result.relative_pose) stage_->publish("relative_pose", result.relative_pose);
    if (result.pose) stage_->publish("pose", result.pose);
    selection.seconds.publish += watch.seconds();
    stage_->publish("selection", result.selection);
    stage_->report(selection.seconds, selection.header.stamp);
    if (selection.n_input > 0) {
      stage_->diagnostics().inlierRatio(static_cast<double>(selection.n_selected) / selection.n_input);
    }
    stage_->diagnostics().confidence(selection.confidence);
    stage_->diagnostics().set("pose", result.verdict);
    stage_->diagnostics().set("prior", core::toString(static_cast<core::GuessVerdict>(selection.guess)));
    if (!result.warning.empty()) stage_->warn(result.warning);
  }

  void configure(SelectorConfig& config, std::uint32_t level) {
    if ((level & LiveSelector::kLevelSelector) == 0) return;
    const LiveSelector::Change change = selector_->configure(config);
    getPrivateNodeHandle().setParam("presets_in_force", selector_->presets());
    for (const std::string& text : change.warnings) NODELET_WARN_STREAM(text);
    if (!change.error.empty()) {
      NODELET_ERROR_STREAM(change.error);
    } else {
      NODELET_INFO_STREAM("selector " << change.spec);
    }
    stage_->diagnostics().set("selector", change.spec);
  }

  std::unique_ptr<LiveSelector> selector_;
  std::unique_ptr<Stage> stage_;  ///< last: it calls what is above
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::SelectorNodelet, nodelet::Nodelet)
