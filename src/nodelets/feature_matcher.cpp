#include <corrsel/FeatureMatcherConfig.h>
#include <dynamic_reconfigure/server.h>
#include <image_transport/image_transport.h>
#include <image_transport/subscriber_filter.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/sync_policies/exact_time.h>
#include <message_filters/synchronizer.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <algorithm>
#include <atomic>
#include <boost/make_shared.hpp>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/features/extractor.h"
#include "corrsel/features/matcher.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/parameters.h"
#include "corrsel/stopwatch.h"

namespace corrsel {

/// Publishes the putative matches of every synchronised image pair on `correspondences`.
class FeatureMatcherNodelet : public nodelet::Nodelet {
 private:
  using Image = sensor_msgs::Image;
  using ExactPolicy = message_filters::sync_policies::ExactTime<Image, Image>;
  using ApproximatePolicy = message_filters::sync_policies::ApproximateTime<Image, Image>;
  using Server = dynamic_reconfigure::Server<FeatureMatcherConfig>;

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    for (const std::string& text : clampedParameters<FeatureMatcherConfig>(pnh)) NODELET_WARN_STREAM(text);
    lazy_ = pnh.param("lazy", true);
    threads_ = std::max(1, pnh.param("threads", 2));
    queue_size_ = static_cast<std::uint32_t>(std::max(1, pnh.param("subscriber_queue_size", 1)));
    transport_ = std::make_unique<image_transport::ImageTransport>(getNodeHandle());
    synchronise();

    server_ = std::make_unique<Server>(server_mutex_, getMTPrivateNodeHandle());
    server_->setCallback(
        [this](FeatureMatcherConfig& config, std::uint32_t level) { reconfigure(config, level); });

    if (lazy_) NODELET_INFO("lazy: images are subscribed while somebody subscribes to correspondences");
    const auto on_change = [this](const ros::SingleSubscriberPublisher&) { updateSubscriptions(); };
    const std::lock_guard<std::mutex> lock(connect_mutex_);  // callbacks wait until publisher_ is set
    publisher_ =
        getNodeHandle().advertise<Correspondences>("correspondences", kPublisherQueue, on_change, on_change);
    if (!lazy_) subscribe();
    statistics_timer_ = getMTNodeHandle().createWallTimer(
        ros::WallDuration(kStatisticsPeriod), [this](const ros::WallTimerEvent&) { reportMisses(); });
  }

  void synchronise() {
    const ros::NodeHandle& pnh = getPrivateNodeHandle();
    const auto queue = static_cast<std::uint32_t>(std::max(1, pnh.param("queue_size", 5)));
    const auto on_pair =
        boost::bind(&FeatureMatcherNodelet::process, this, boost::placeholders::_1, boost::placeholders::_2);
    if (pnh.param("approximate_sync", false)) {
      approximate_ = std::make_unique<message_filters::Synchronizer<ApproximatePolicy>>(
          ApproximatePolicy(queue), left_, right_);
      const double interval = pnh.param("approximate_sync_max_interval", 0.0);
      if (interval > 0.0) approximate_->setMaxIntervalDuration(ros::Duration(interval));
      approximate_->registerCallback(on_pair);
    } else {
      exact_ =
          std::make_unique<message_filters::Synchronizer<ExactPolicy>>(ExactPolicy(queue), left_, right_);
      exact_->registerCallback(on_pair);
    }
    left_.registerCallback([this](const sensor_msgs::ImageConstPtr&) { ++n_left_; });
    right_.registerCallback([this](const sensor_msgs::ImageConstPtr&) { ++n_right_; });
  }

  void updateSubscriptions() {
    const std::lock_guard<std::mutex> lock(connect_mutex_);
    if (!lazy_) return;
    if (publisher_.getNumSubscribers() > 0) {
      subscribe();
    } else if (subscribed_) {
      left_.unsubscribe();
      right_.unsubscribe();
      subscribed_ = false;
    }
  }

  void subscribe() {
    if (subscribed_) return;
    const image_transport::TransportHints hints("raw", ros::TransportHints(), getPrivateNodeHandle());
    left_.subscribe(*transport_, "left/image", queue_size_, hints);
    right_.subscribe(*transport_, "right/image", queue_size_, hints);
    subscribed_ = true;
  }

  void process(const sensor_msgs::ImageConstPtr& left, const sensor_msgs::ImageConstPtr& right) {
    ++n_pairs_;
    std::shared_ptr<const core::FeatureExtractor> extractor;
    {
      const std::lock_guard<std::mutex> lock(extractor_mutex_);
      extractor = extractor_;
    }
    if (!extractor) return;
    std::string topic = left_.getTopic();
    try {
      const cv_bridge::CvImageConstPtr left_image = fromMsg(left);
      topic = right_.getTopic();
      const cv_bridge::CvImageConstPtr right_image = fromMsg(right);
      topic += " or " + left_.getTopic();
      const auto features = core::extractPair(*extractor, left_image->image, right_image->image, threads_);
      const core::Stopwatch watch;
      const core::Correspondences matches = core::matchFeatures(features.first, features.second);
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
    const std::string prefix = config.features.substr(0, config.features.find('+')) + "_";
    return core::createExtractor(config.features, changedOptions(config, prefix));
  }

  /// Says why nothing comes out when images arrive but do not pair up.
  void reportMisses() {
    const std::size_t left = n_left_.exchange(0), right = n_right_.exchange(0), pairs = n_pairs_.exchange(0);
    if (std::max(left, right) < 3 || std::max(left, right) < 3 * pairs) return;
    NODELET_WARN_STREAM(
        "in " << kStatisticsPeriod << " s: " << left << " left images (" << left_.getTopic() << "), " << right
              << " right images (" << right_.getTopic() << "), but only " << pairs
              << " pairs. Are both topics published? Do their stamps agree? If not exactly, set "
                 "~approximate_sync; if one arrives later than the other, enlarge ~queue_size.");
  }

  static constexpr std::uint32_t kPublisherQueue = 10;
  static constexpr std::uint32_t kLevelFeatures = 1;
  static constexpr double kStatisticsPeriod = 15.0;  ///< s, wall time

  bool lazy_ = true;
  int threads_ = 2;
  std::uint32_t queue_size_ = 1;
  std::atomic<std::size_t> n_left_{0}, n_right_{0}, n_pairs_{0};
  std::mutex connect_mutex_;  ///< guards subscribed_ and publisher_
  bool subscribed_ = false;
  ros::Publisher publisher_;
  std::mutex extractor_mutex_;  ///< guards extractor_, which is written under server_mutex_ only
  std::shared_ptr<const core::FeatureExtractor> extractor_;
  FeatureMatcherConfig accepted_ = FeatureMatcherConfig::__getDefault__();  ///< the newest one that worked
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<image_transport::ImageTransport> transport_;
  image_transport::SubscriberFilter left_, right_;
  std::unique_ptr<message_filters::Synchronizer<ExactPolicy>> exact_;
  std::unique_ptr<message_filters::Synchronizer<ApproximatePolicy>> approximate_;
  ros::WallTimer statistics_timer_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::FeatureMatcherNodelet, nodelet::Nodelet)
