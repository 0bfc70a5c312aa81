#include <corrsel/FeatureMatcherConfig.h>
#include <nodelet/nodelet.h>

#include <boost/shared_ptr.hpp>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/Features.h"
#include "corrsel/features/image_faults.h"
#include "corrsel/ros/conversions.h"
#include "ros/live/image_mask.h"
#include "ros/live/image_report.h"
#include "ros/live/image_source.h"
#include "ros/live/live_matcher.h"
#include "ros/live/live_stage.h"
#include "ros/live/matcher_settings.h"
#include "ros/live/motion_source.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"

namespace corrsel {

/// Publishes the putative matches of every image pair, or of every image with an earlier one, on
/// `correspondences`, and in a sequence the features of the newest image on `features`.
class FeatureMatcherNodelet : public nodelet::Nodelet {
  using Stage = LiveStage<ImageSet, FeatureMatcherConfig>;

  void onInit() override {
    FeatureMatcherParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    sequence_ = parameters.mode == FeatureMatcherParameters::Mode::kSequence;
    motion_ = openMotionSource(getNodeHandle(), parameters);
    LiveMatcher::Setup setup;
    setup.threads = parameters.threads;
    setup.motion = motion_.get();
    setup.quality = parameters.image_quality;
    setup.left_mask = sequence_ ? fixedMask("mask_file", parameters.mask_file)
                                : fixedMask("left_mask_file", parameters.left_mask_file);
    if (!sequence_) setup.right_mask = fixedMask("right_mask_file", parameters.right_mask_file);
    matcher_ = std::make_unique<LiveMatcher>(setup);
    settings_ =
        std::make_unique<MatcherSettings>(parameters.tracker == FeatureMatcherParameters::Tracker::kFlow);
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
    std::vector<ros::AdvertiseOptions> outputs = {Stage::output<Correspondences>("correspondences")};
    if (sequence_) outputs.push_back(Stage::output<Features>("features"));
    stage_->start(outputs);
  }

  /// The mask of a file; empty where none is given, and after an error, which is logged.
  cv::Mat fixedMask(const std::string& parameter, const std::string& path) {
    if (path.empty()) return {};
    try {
      return readMaskFile(path);
    } catch (const std::runtime_error& error) {
      NODELET_ERROR_STREAM("parameter " << getPrivateNodeHandle().resolveName(parameter)
                                        << " is ignored: " << error.what());
      return {};
    }
  }

  void match(const ImageSet& images) {
    const boost::shared_ptr<Correspondences> message = matcher_->match(images, settings_->current());
    // They come before their matches, so that whoever has a match has the features, too.
    if (sequence_ && stage_->isWanted("features")) {
      if (const auto features = matcher_->newestFeatures()) stage_->publish("features", features);
    }
    if (!message) return;  // the first image of a sequence
    stage_->report(message->seconds, message->header.stamp);
    LiveDiagnostics& diagnostics = stage_->diagnostics();
    diagnostics.set("cameras", camerasText(*message));
    diagnostics.set("left image", core::toText(fromMsg(message->left_quality)));
    diagnostics.set("right image", core::toText(fromMsg(message->right_quality)));
    diagnostics.imageFaults(imageFaults(*message));
    if (motion_) {
      diagnostics.set("prior", matcher_->guesses().text());
      const std::string warning = matcher_->guesses().warning();
      if (!warning.empty()) stage_->warn(motion_->name() + " " + warning);
    }
    stage_->publish("correspondences", message);
  }

  void configure(FeatureMatcherConfig& config, std::uint32_t level) {
    const MatcherSettings::Change change = settings_->configure(config, level);
    if (!change.error.empty()) NODELET_ERROR_STREAM(change.error);
    if (!change.new_features) return;
    NODELET_INFO_STREAM("features " << change.features);
    stage_->diagnostics().set("features", change.features);
  }

  bool sequence_ = false;
  std::unique_ptr<MotionSource> motion_;  ///< null = nothing is known of the motion
  std::unique_ptr<LiveMatcher> matcher_;  ///< used on the thread of the stage's queue only
  std::unique_ptr<MatcherSettings> settings_;
  std::unique_ptr<Stage> stage_;  ///< last: it calls what is above
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::FeatureMatcherNodelet, nodelet::Nodelet)
