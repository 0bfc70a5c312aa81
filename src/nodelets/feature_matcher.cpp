#include <corrsel/FeatureMatcherConfig.h>
#include <dynamic_reconfigure/server.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/features/extractor.h"
#include "corrsel/features/matcher.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/image_source.h"
#include "corrsel/ros/parameters.h"
#include "corrsel/stopwatch.h"

namespace corrsel {

/// Publishes the putative matches of every synchronised image pair on `correspondences`.
class FeatureMatcherNodelet : public nodelet::Nodelet {
 private:
  using Server = dynamic_reconfigure::Server<FeatureMatcherConfig>;

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    for (const std::string& text : clampedParameters<FeatureMatcherConfig>(pnh)) NODELET_WARN_STREAM(text);
    lazy_ = pnh.param("lazy", true);
    threads_ = std::max(1, pnh.param("threads", 2));
    images_ = openImageSource(getNodeHandle(), pnh,
                              [this](const ImageSet& images) { process(images.left, images.right); });

    server_ = std::make_unique<Server>(server_mutex_, getMTPrivateNodeHandle());
    server_->setCallback(
        [this](FeatureMatcherConfig& config, std::uint32_t level) { reconfigure(config, level); });

    if (lazy_) NODELET_INFO("lazy: images are subscribed while somebody subscribes to correspondences");
    const auto on_change = [this](const ros::SingleSubscriberPublisher&) { updateSubscriptions(); };
    const std::lock_guard<std::mutex> lock(connect_mutex_);  // callbacks wait until publisher_ is set
    publisher_ =
        getNodeHandle().advertise<Correspondences>("correspondences", kPublisherQueue, on_change, on_change);
    if (!lazy_) images_->subscribe();
    statistics_timer_ = getMTNodeHandle().createWallTimer(
        ros::WallDuration(kStatisticsPeriod), [this](const ros::WallTimerEvent&) {
          const std::string text = images_->complaint();
          if (!text.empty()) NODELET_WARN_STREAM("in " << kStatisticsPeriod << " s: " << text);
        });
  }

  void updateSubscriptions() {
    const std::lock_guard<std::mutex> lock(connect_mutex_);
    if (!lazy_) return;
    if (publisher_.getNumSubscribers() > 0) {
      images_->subscribe();
    } else {
      images_->unsubscribe();
    }
  }

  void process(const sensor_msgs::ImageConstPtr& left, const sensor_msgs::ImageConstPtr& right) {
    std::shared_ptr<const core::FeatureExtractor> extractor;
    core::MatchOptions match;
    {
      const std::lock_guard<std::mutex> lock(extractor_mutex_);
      extractor = extractor_;
      match = match_;
    }
    if (!extractor) return;
    const std::vector<std::string> topics = images_->topics();
    std::string topic = topics.front();
    try {
      const cv_bridge::CvImageConstPtr left_image = fromMsg(left);
      topic = topics.back();
      const cv_bridge::CvImageConstPtr right_image = fromMsg(right);
      topic += " or " + topics.front();
      const auto features = core::extractPair(*extractor, left_image->image, right_image->image, threads_);
      const core::Stopwatch watch;
      const core::Correspondences matches =
          core::matchFeatures(features.first, features.second, match, threads_);
      PairInfo info;
      info.match_seconds = watch.seconds();
      info.header = left->header;
      info.right_stamp = right->header.stamp;
      info.right_frame_id = right->header.frame_id;
      info.features = extractor->name();
      info.n_left_features = static_cast<std::uint32_t>(features.first.keypoints.size());
      info.n_right_features = static_cast<std::uint32_t>(features.second.keypoints.size());
      info.detect_seconds = features.first.detect_seconds + features.second.detect_seconds;
      info.describe_seconds = features.first.describe_seconds + features.second.describe_seconds;
      publisher_.publish(boost::make_shared<Correspondences>(toMsg(matches, info)));
    } catch (const std::exception& error) {  // unsupported encodings, images without pixels, OpenCV
      NODELET_WARN_STREAM_THROTTLE(5.0, topic << ": pair dropped: " << error.what());
    }
  }

  void reconfigure(FeatureMatcherConfig& config, std::uint32_t level) {
    if ((level & kLevelMatch) != 0) {
      core::MatchOptions match;
      core::setOptions(match, changedOptions(config, "match_"), "match");  // in range: the server clamps
      const std::lock_guard<std::mutex> lock(extractor_mutex_);
      match_ = match;
    }
    if ((level & kLevelFeatures) == 0) return;
    std::shared_ptr<const core::FeatureExtractor> extractor;
    try {
      extractor = create(config);
    } catch (const std::exception& error) {
      NODELET_ERROR_STREAM("features not changed: " << error.what() << "; " << accepted_.features
                                                    << " stays in force with the options it had");
      config = accepted_;
      if (extractor_) return;
      extractor = create(config);  // at start-up: the defaults
    }
    accepted_ = config;
    NODELET_INFO_STREAM("features " << extractor->name());
    const std::lock_guard<std::mutex> lock(extractor_mutex_);
    extractor_ = extractor;
  }

  static std::shared_ptr<const core::FeatureExtractor> create(const FeatureMatcherConfig& config) {
    core::AlgorithmOptions options;
    for (const std::string& algorithm : core::algorithmsOf(config.features)) {
      options[algorithm] = changedOptions(config, algorithm + "_");
    }
    return core::createExtractor(config.features, options);
  }

  static constexpr std::uint32_t kPublisherQueue = 10;
  static constexpr std::uint32_t kLevelFeatures = 1, kLevelMatch = 2;
  static constexpr double kStatisticsPeriod = 15.0;  ///< s, wall time

  bool lazy_ = true;
  int threads_ = 2;
  std::mutex connect_mutex_;  ///< guards publisher_ and the subscriptions of images_
  ros::Publisher publisher_;
  std::mutex extractor_mutex_;  ///< guards extractor_ and match_, which are written under server_mutex_ only
  std::shared_ptr<const core::FeatureExtractor> extractor_;
  core::MatchOptions match_;
  FeatureMatcherConfig accepted_ = FeatureMatcherConfig::__getDefault__();  ///< the newest one that worked
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<ImageSource> images_;
  ros::WallTimer statistics_timer_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::FeatureMatcherNodelet, nodelet::Nodelet)
