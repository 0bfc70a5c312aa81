#include <corrsel/FeatureMatcherConfig.h>
#include <nodelet/nodelet.h>

#include <boost/shared_ptr.hpp>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>

#include "corrsel/Correspondences.h"
#include "ros/live/image_source.h"
#include "ros/live/live_matcher.h"
#include "ros/live/live_stage.h"
#include "ros/live/matcher_settings.h"
#include "ros/live/motion_source.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"

namespace corrsel {

/// Publishes the putative matches of every image pair, or of every image with an earlier one, on
/// `correspondences`.
class FeatureMatcherNodelet : public nodelet::Nodelet {
  using Stage = LiveStage<ImageSet, FeatureMatcherConfig>;

  void onInit() override {
    FeatureMatcherParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    motion_ = openMotionSource(getNodeHandle(), parameters);
    matcher_ = std::make_unique<LiveMatcher>(parameters.threads, motion_.get());
    Stage::Parts parts;
    parts.open = [&](const ros::NodeHandle& nh, Stage::Put put) -> std::unique_ptr<LiveSource> {
      auto images = openImageSource(nh, getPrivateNodeHandle(), parameters, std::move(put));
      if (!motion_) return images;
      return std::make_unique<JointSource>(std::move(images), *motion_);
    };
    parts.work = [this](const ImageSet& images) { match(images); };
    parts.configure = [this](FeatureMatcherConfig& config, std::uint32_t level) { configure(config, level); };
    stage_ = std::make_unique<Stage>(getNodeHandle(), getPrivateNodeHandle(), getName(), parameters,
                                     std::move(parts));
    stage_->start({Stage::output<Correspondences>("correspondences")});
  }

  void match(const ImageSet& images) {
    const boost::shared_ptr<Correspondences> message = matcher_->match(images, settings_.current());
    if (!message) return;  // the first image of a sequence
    stage_->report(message->seconds, message->header.stamp);
    stage_->diagnostics().set("cameras", camerasText(*message));
    if (motion_) {
      stage_->diagnostics().set("prior", matcher_->guesses().text());
      const std::string warning = matcher_->guesses().warning();
      if (!warning.empty()) stage_->warn(motion_->name() + " " + warning);
    }
    stage_->publish("correspondences", message);
  }

  void configure(FeatureMatcherConfig& config, std::uint32_t level) {
    const MatcherSettings::Change change = settings_.configure(config, level);
    if (!change.error.empty()) NODELET_ERROR_STREAM(change.error);
    if (!change.new_features) return;
    NODELET_INFO_STREAM("features " << change.features);
    stage_->diagnostics().set("features", change.features);
  }

  std::unique_ptr<MotionSource> motion_;  ///< null = nothing is known of the motion
  std::unique_ptr<LiveMatcher> matcher_;  ///< used on the thread of the stage's queue only
  MatcherSettings settings_;
  std::unique_ptr<Stage> stage_;  ///< last: it calls what is above
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::FeatureMatcherNodelet, nodelet::Nodelet)
