#include <corrsel/SelectorConfig.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nodelet/nodelet.h>
#include <ros/param.h>

#include <algorithm>
#include <memory>
#include <optional>
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
#include "ros/live/masked_source.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"

namespace corrsel {

/// Publishes, for every message on `correspondences`, the matches that the chosen selector keeps (`matches`),
/// those that move by themselves where this is asked for (`moving`), its decision (`selection`), and, if it
/// estimates one, the pose between the images (`relative_pose`, `pose`).
class SelectorNodelet : public nodelet::Nodelet {
  struct Item {
    TimedMatches matches;
    std::optional<PairMasks> masks;  ///< where stamped masks are used
  };
  using Stage = LiveStage<Item, SelectorConfig>;

  /// Pairs that may wait where masks are used: one mask shows of all earlier pairs that they get none.
  static constexpr int kReleasedAtOnce = 10;

  void onInit() override {
    enableSelectorPlugins();
    SelectorParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    for (const std::string& text : unreadParameters(ownParameters())) NODELET_ERROR_STREAM(text);
    selector_ = std::make_unique<LiveSelector>(parameters.presets_in_force);
    const bool masked = parameters.use_mask && parameters.mask_mode == MaskMode::kStamped;
    if (masked) parameters.pending = std::max(parameters.pending, kReleasedAtOnce);
    Stage::Parts parts;
    parts.open = [&](const ros::NodeHandle& nh, Stage::Put put) {
      return masked ? openMasked(nh, parameters, std::move(put))
                    : openUnmasked(nh, parameters, std::move(put));
    };
    parts.work = [this](const Item& item) { select(item); };
    parts.configure = [this](SelectorConfig& config, std::uint32_t level) { configure(config, level); };
    stage_ = std::make_unique<Stage>(getNodeHandle(), getPrivateNodeHandle(), getName(), parameters,
                                     std::move(parts));
    stage_->diagnostics().limitInlierRatio(parameters.warn_inlier_ratio, parameters.error_inlier_ratio);
    stage_->start({Stage::output<Correspondences>("matches"), Stage::output<Correspondences>("moving"),
                   Stage::output<Selection>("selection"), Stage::output<RelativePose>("relative_pose"),
                   Stage::output<geometry_msgs::PoseWithCovarianceStamped>("pose")});
  }

  static std::unique_ptr<LiveSource> openUnmasked(const ros::NodeHandle& nh,
                                                  const SelectorParameters& parameters, Stage::Put put) {
    return std::make_unique<MessageSource<Correspondences>>(
        nh, "correspondences", static_cast<std::uint32_t>(parameters.subscriber_queue_size),
        [put = std::move(put)](const CorrespondencesConstPtr& message) {
          put({{message, core::Stopwatch()}, std::nullopt});
        });
  }

  std::unique_ptr<LiveSource> openMasked(const ros::NodeHandle& nh, const SelectorParameters& parameters,
                                         Stage::Put put) {
    auto source = std::make_unique<MaskedSource>(
        nh, parameters,
        [put = std::move(put)](TimedMatches matches, PairMasks masks) {
          put({std::move(matches), std::move(masks)});
        },
        [this](const std::string& problem) { stage_->warn(problem); });
    masked_source_ = source.get();
    return source;
  }

  void reportMasks() {
    const MaskedSource::Gate::Counts counts = masked_source_->counts();
    stage_->diagnostics().set("masks", std::to_string(counts.masks));
    stage_->diagnostics().set("masks that found no pair", std::to_string(counts.masks_unused));
    stage_->diagnostics().set("pairs with their masks", std::to_string(counts.pairs_masked));
    stage_->diagnostics().set("pairs without a mask", std::to_string(counts.pairs_unmasked));
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
    const LiveSelector::Result result =
        selector_->select(*item.matches.message, item.matches.waiting.seconds(), item.masks);
    Selection& selection = *result.selection;
    const core::Stopwatch watch;
    stage_->publish("matches", result.matches);
    if (result.moving) stage_->publish("moving", result.moving);
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
    if (masked_source_ != nullptr) reportMasks();
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
  const MaskedSource* masked_source_ = nullptr;  ///< of stage_; null where no stamped masks are used
  std::unique_ptr<Stage> stage_;                 ///< last: it calls what is above
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::SelectorNodelet, nodelet::Nodelet)
