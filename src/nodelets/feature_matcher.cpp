#include <corrsel/FeatureMatcherConfig.h>
#include <dynamic_reconfigure/server.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "ros/live/callback_thread.h"
#include "ros/live/image_source.h"
#include "ros/live/live_diagnostics.h"
#include "ros/live/live_matcher.h"
#include "ros/live/on_demand.h"
#include "ros/live/parameters.h"
#include "ros/live/periodic.h"
#include "ros/live/wall_throttle.h"
#include "ros/live/work_queue.h"

namespace corrsel {

/// Publishes the putative matches of every image pair, or of every image with an earlier one, on
/// `correspondences`.
class FeatureMatcherNodelet : public nodelet::Nodelet {
 public:
  ~FeatureMatcherNodelet() override {
    for (CallbackThread* thread : {&images_thread_, &server_thread_}) thread->stop();
    if (queue_) queue_->stop();
  }

 private:
  using Server = dynamic_reconfigure::Server<FeatureMatcherConfig>;

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    for (const std::string& text : clampedParameters<FeatureMatcherConfig>(pnh)) NODELET_WARN_STREAM(text);
    matcher_ = std::make_unique<LiveMatcher>(std::max(1, pnh.param("threads", 2)));
    queue_ = std::make_unique<WorkQueue<ImageSet>>(std::max(1, pnh.param("pending", 1)),
                                                   [this](const ImageSet& images) { process(images); });
    images_ = openSource();
    const bool lazy = pnh.param("lazy", true);
    demand_ = std::make_unique<OnDemand>(
        lazy, [this] { return publisher_.getNumSubscribers() > 0; }, [this] { images_->subscribe(); },
        [this] { images_->unsubscribe(); });
    diagnostics_ = std::make_unique<LiveDiagnostics>(server_thread_.handle(getNodeHandle()), pnh, getName(),
                                                     [this] { return flow(); });

    server_ = std::make_unique<Server>(server_mutex_, server_thread_.handle(pnh));
    server_->setCallback(
        [this](FeatureMatcherConfig& config, std::uint32_t level) { reconfigure(config, level); });

    if (lazy) NODELET_INFO("lazy: images are subscribed while somebody subscribes to correspondences");
    const auto on_change = [this](const ros::SingleSubscriberPublisher&) { demand_->update(); };
    {
      const auto lock = demand_->hold();
      publisher_ = images_thread_.handle(getNodeHandle())
                       .advertise<Correspondences>("correspondences", kPublisherQueue, on_change, on_change);
    }
    demand_->update();
    complaints_ = std::make_unique<Periodic>(kComplaintPeriod, [this] { complain(); });
  }

  std::unique_ptr<ImageSource> openSource() {
    const auto hand_over = [this](ImageSet images) { queue_->put(std::move(images)); };
    try {
      return openImageSource(images_thread_.handle(getNodeHandle()), getPrivateNodeHandle(), hand_over);
    } catch (const std::invalid_argument& error) {
      NODELET_ERROR_STREAM(error.what() << "; pair is used");
      getPrivateNodeHandle().setParam("mode", "pair");
      return openImageSource(images_thread_.handle(getNodeHandle()), getPrivateNodeHandle(), hand_over);
    }
  }

  /// On the thread of the queue.
  void process(const ImageSet& images) {
    const LiveMatcher::Settings settings = current();
    try {
      const boost::shared_ptr<Correspondences> message = matcher_->match(images, settings);
      if (!message) return;  // the first image of a sequence
      diagnostics_->answered({{"wait", message->seconds.wait},
                              {"detect", message->seconds.detect},
                              {"describe", message->seconds.describe},
                              {"match", message->seconds.match},
                              {"publish", message->seconds.publish},
                              {"age", ros::Time::now().toSec() - images.left->header.stamp.toSec()}});
      publisher_.publish(message);
    } catch (const std::exception& error) {  // encodings, images without pixels, masks, OpenCV
      const std::string text = joinedTopics() + ": dropped: " + error.what();
      diagnostics_->failed(text);
      if (warning_.due()) NODELET_WARN_STREAM(text);
    }
  }

  LiveMatcher::Settings current() {
    const std::lock_guard<std::mutex> lock(settings_mutex_);
    return settings_;
  }

  std::string joinedTopics() const {
    std::string text;
    for (const std::string& topic : images_->topics()) text += (text.empty() ? "" : " or ") + topic;
    return text;
  }

  LiveDiagnostics::Flow flow() {
    LiveDiagnostics::Flow flow;
    const ImageSource::Counts counts = images_->counts();
    const WorkQueue<ImageSet>::Counts work = queue_->counts();
    flow.wanted = demand_->running();
    if (images_->topics().size() == 2) {
      flow.inputs = {{"left", counts.left}, {"right", counts.right}, {"pair", counts.sets}};
    } else {
      flow.inputs = {{"image", counts.left}};
    }
    flow.done = work.done;
    flow.dropped = work.dropped;
    return flow;
  }

  void complain() {
    const std::string text = images_->complaint();
    if (text.empty()) return;
    diagnostics_->failed(text);
    NODELET_WARN_STREAM("in " << kComplaintPeriod << " s: " << text);
  }

  void reconfigure(FeatureMatcherConfig& config, std::uint32_t level) {
    LiveMatcher::Settings settings;
    settings.extractor = current().extractor;
    try {
      core::setOptions(settings.match, changedOptions(config, "match_"), "match");
      core::setOptions(settings.sequence, changedOptions(config, "sequence_"), "sequence");
      settings.area = cv::Rect(config.roi_x, config.roi_y, config.roi_width, config.roi_height);
      if (!settings.extractor || (level & kLevelFeatures) != 0) settings.extractor = create(config);
    } catch (const std::exception& error) {
      NODELET_ERROR_STREAM("not changed: " << error.what() << "; " << accepted_.features
                                           << " stays in force with the options it had");
      config = accepted_;
      if (settings.extractor) return;
      settings = {};
      settings.extractor = create(config);  // at start-up: the defaults
    }
    accepted_ = config;
    if ((level & kLevelFeatures) != 0) {
      NODELET_INFO_STREAM("features " << settings.extractor->name());
      diagnostics_->set("features", settings.extractor->name());
    }
    const std::lock_guard<std::mutex> lock(settings_mutex_);
    settings_ = settings;
  }

  static std::shared_ptr<const core::FeatureExtractor> create(const FeatureMatcherConfig& config) {
    core::AlgorithmOptions options;
    for (const std::string& algorithm : core::algorithmsOf(config.features)) {
      options[algorithm] = changedOptions(config, algorithm + "_");
    }
    return core::createExtractor(config.features, options);
  }

  static constexpr std::uint32_t kPublisherQueue = 10;
  static constexpr std::uint32_t kLevelFeatures = 1;
  static constexpr double kComplaintPeriod = 15.0;  ///< s, wall time

  // Order of destruction: what calls goes before what is called.
  CallbackThread images_thread_;  ///< images and who subscribes to the matches
  CallbackThread server_thread_;  ///< reconfiguring: a slow pair does not hold it up
  ros::Publisher publisher_;
  std::unique_ptr<LiveMatcher> matcher_;  ///< used on the thread of queue_ only
  std::mutex settings_mutex_;             ///< guards settings_, which is written under server_mutex_ only
  LiveMatcher::Settings settings_;
  FeatureMatcherConfig accepted_ = FeatureMatcherConfig::__getDefault__();  ///< the newest one that worked
  WallThrottle warning_;
  std::unique_ptr<WorkQueue<ImageSet>> queue_;
  std::unique_ptr<ImageSource> images_;
  std::unique_ptr<OnDemand> demand_;
  std::unique_ptr<LiveDiagnostics> diagnostics_;
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Periodic> complaints_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::FeatureMatcherNodelet, nodelet::Nodelet)
