#include <corrsel/MatcherConfig.h>
#include <nodelet/nodelet.h>

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>

#include "corrsel/Correspondences.h"
#include "ros/live/feature_source.h"
#include "ros/live/live_stage.h"
#include "ros/live/message_matcher.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"

namespace corrsel {

/// Publishes the putative matches of features that other nodes have found, such as a network, on
/// `correspondences`.
class MatcherNodelet : public nodelet::Nodelet {
  using Stage = LiveStage<FeatureSet, MatcherConfig>;

  void onInit() override {
    MatcherParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    matcher_ = std::make_unique<MessageMatcher>(parameters.threads);
    Stage::Parts parts;
    parts.open = [&](const ros::NodeHandle& nh, Stage::Put put) {
      return std::make_unique<FeatureSource>(nh, parameters, std::move(put));
    };
    parts.work = [this](const FeatureSet& set) { match(set); };
    parts.configure = [this](MatcherConfig& config, std::uint32_t level) { configure(config, level); };
    stage_ = std::make_unique<Stage>(getNodeHandle(), getPrivateNodeHandle(), getName(), parameters,
                                     std::move(parts));
    stage_->start({Stage::output<Correspondences>("correspondences")});
  }

  void match(const FeatureSet& set) {
    const boost::shared_ptr<Correspondences> message = matcher_->match(set);
    if (!message) return;  // the first frame of a sequence
    stage_->report(message->seconds, message->header.stamp);
    stage_->publish("correspondences", message);
  }

  void configure(MatcherConfig& config, std::uint32_t level) {
    const MessageMatcher::Change change = matcher_->configure(config, level);
    if (!change.error.empty()) NODELET_ERROR_STREAM(change.error);
    if (!change.new_matcher) return;
    NODELET_INFO_STREAM("matcher " << change.matcher);
    stage_->diagnostics().set("matcher", change.matcher);
  }

  std::unique_ptr<MessageMatcher> matcher_;
  std::unique_ptr<Stage> stage_;  ///< last: it calls what is above
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::MatcherNodelet, nodelet::Nodelet)
