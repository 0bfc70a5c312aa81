#include <corrsel/TrackerConfig.h>
#include <nodelet/nodelet.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>

#include "corrsel/Tracks.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/selector_plugins.h"
#include "ros/live/live_stage.h"
#include "ros/live/live_tracker.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"
#include "ros/live/track_source.h"

namespace corrsel {

/// Publishes, for every `selection` of a sequence, the tracks of the newest image on `tracks`, and writes
/// them to a file.
class TrackerNodelet : public nodelet::Nodelet {
  using Stage = LiveStage<TrackItem, TrackerConfig>;

  void onInit() override {
    enableSelectorPlugins();
    TrackerParameters parameters;
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters)) {
      NODELET_ERROR_STREAM(text);
    }
    tracker_ = std::make_unique<LiveTracker>(parameters);
    if (!parameters.file.empty()) {
      openFile(parameters.file);
      parameters.lazy = false;
    }
    Stage::Parts parts;
    parts.open = [&](const ros::NodeHandle& nh, Stage::Put put) {
      return std::make_unique<TrackSource>(nh, parameters, std::move(put));
    };
    parts.work = [this](const TrackItem& item) { track(item); };
    parts.configure = [this](TrackerConfig& config, std::uint32_t level) { configure(config, level); };
    stage_ = std::make_unique<Stage>(getNodeHandle(), getPrivateNodeHandle(), getName(), parameters,
                                     std::move(parts));
    stage_->start({Stage::output<Tracks>("tracks")});
  }

  void openFile(const std::string& path) {
    try {
      tracker_->openFile(path);
      NODELET_INFO_STREAM("tracks are written to " << path);
    } catch (const std::exception& error) {
      NODELET_ERROR_STREAM(error.what());
    }
  }

  void track(const TrackItem& item) {
    StageTimes times = unmeasured();
    times.wait = item.waiting.seconds();
    const LiveTracker::Result result = tracker_->add(item);
    const Tracks& tracks = *result.tracks;
    stage_->publish("tracks", result.tracks);
    times.publish = tracks.seconds;
    stage_->report(times, tracks.header.stamp);
    stage_->diagnostics().set(
        "tracks", std::to_string(tracks.n_continued) + " continued, " + std::to_string(tracks.n_bridged) +
                      " bridged, " + std::to_string(tracks.n_begun) + " begun, " +
                      std::to_string(tracks.n_cut) + " cut, " + std::to_string(tracks.n_lost) + " lost");
    if (!result.warning.empty()) stage_->warn(result.warning);
  }

  void configure(TrackerConfig& config, std::uint32_t level) {
    if ((level & LiveTracker::kLevelTracker) == 0) return;
    const std::string error = tracker_->configure(config);
    if (!error.empty()) NODELET_ERROR_STREAM(error);
    stage_->diagnostics().set("selector", config.selector);
  }

  std::unique_ptr<LiveTracker> tracker_;
  std::unique_ptr<Stage> stage_;  ///< last: it calls what is above
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::TrackerNodelet, nodelet::Nodelet)
