#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <vector>

#include "corrsel/evaluation/errors.h"
#include "corrsel/matching/match_drawing.h"
#include "corrsel/ros/conversions.h"
#include "ros/live/callback_thread.h"
#include "ros/live/image_subscriber.h"
#include "ros/live/on_demand.h"
#include "ros/live/stamp_cache.h"
#include "ros/live/wall_throttle.h"

namespace corrsel {

/// Draws what a selector decided on `matches/image`, but only while somebody looks. Images, `correspondences`
/// and `selection` are brought together by their stamps; `ground_truth`, where there is any, gives the
/// colours.
class MatchViewerNodelet : public nodelet::Nodelet {
 public:
  ~MatchViewerNodelet() override { thread_.stop(); }

 private:
  /// What has arrived for one pair, by the stamp of the left image.
  struct Pending {
    sensor_msgs::ImageConstPtr left;
    CorrespondencesConstPtr correspondences;
    SelectionConstPtr selection;
    GroundTruthConstPtr truth;
  };

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    const bool lazy = pnh.param("lazy", true);
    tolerance_ = pnh.param("tolerance", tolerance_);
    max_lines_ = static_cast<std::size_t>(std::max(1, pnh.param("max_lines", 200)));
    queue_size_ = static_cast<std::uint32_t>(std::max(1, pnh.param("subscriber_queue_size", 5)));
    const auto cache_size = static_cast<std::size_t>(std::max(1, pnh.param("cache_size", 10)));
    pending_ = std::make_unique<StampCache<Pending>>(cache_size);
    right_images_ = std::make_unique<StampCache<sensor_msgs::ImageConstPtr>>(cache_size);
    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    transport_ = std::make_unique<image_transport::ImageTransport>(nh);
    left_ = std::make_unique<ImageSubscriber>(nh, pnh, "left/image", queue_size_,
                                              [this](const sensor_msgs::ImageConstPtr& msg) { onLeft(msg); });
    right_ = std::make_unique<ImageSubscriber>(
        nh, pnh, "right/image", queue_size_, [this](const sensor_msgs::ImageConstPtr& msg) { onRight(msg); });

    if (lazy) NODELET_INFO("lazy: nothing is subscribed or drawn until somebody subscribes to matches/image");
    demand_ = std::make_unique<OnDemand>(
        lazy, [this] { return publisher_.getNumSubscribers() > 0; }, [this] { subscribe(); },
        [this] { unsubscribe(); });
    const auto on_change = [this](const image_transport::SingleSubscriberPublisher&) { demand_->update(); };
    {
      const auto lock = demand_->hold();
      publisher_ = transport_->advertise("matches/image", 1, on_change, on_change);
    }
    demand_->update();
  }

  void unsubscribe() {
    left_->unsubscribe();
    right_->unsubscribe();
    subscribers_.clear();
  }

  void subscribe() {
    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    subscribers_.push_back(nh.subscribe("ground_truth", queue_size_, &MatchViewerNodelet::onTruth, this));
    subscribers_.push_back(
        nh.subscribe("correspondences", queue_size_, &MatchViewerNodelet::onCorrespondences, this));
    subscribers_.push_back(nh.subscribe("selection", queue_size_, &MatchViewerNodelet::onSelection, this));
    left_->subscribe();
    right_->subscribe();
  }

  void onLeft(const sensor_msgs::ImageConstPtr& msg) {
    Pending& pending = (*pending_)[msg->header.stamp];
    pending.left = msg;
    draw(pending);
  }

  void onRight(const sensor_msgs::ImageConstPtr& msg) {
    (*right_images_)[msg->header.stamp] = msg;
    for (auto& entry : *pending_) {
      const CorrespondencesConstPtr& correspondences = entry.second.correspondences;
      if (correspondences && correspondences->right_stamp == msg->header.stamp) draw(entry.second);
    }
  }

  void onCorrespondences(const CorrespondencesConstPtr& msg) {
    Pending& pending = (*pending_)[msg->header.stamp];
    pending.correspondences = msg;
    draw(pending);
  }

  void onSelection(const SelectionConstPtr& msg) {
    Pending& pending = (*pending_)[msg->header.stamp];
    pending.selection = msg;
    draw(pending);
  }

  void onTruth(const GroundTruthConstPtr& msg) { (*pending_)[msg->header.stamp].truth = msg; }

  void draw(Pending& pending) {
    if (!pending.left || !pending.correspondences || !pending.selection) return;
    const sensor_msgs::ImageConstPtr* right = right_images_->find(pending.correspondences->right_stamp);
    if (right == nullptr) return;
    try {
      const cv_bridge::CvImageConstPtr left_image = fromMsg(pending.left);
      const cv_bridge::CvImageConstPtr right_image = fromMsg(*right);
      const core::Correspondences matches = fromMsg(*pending.correspondences);
      const core::Selection selection = fromMsg(*pending.selection);
      if (selection.mask.size() != matches.size()) {
        throw std::invalid_argument("selection and correspondences differ in length");
      }
      const cv::Mat picture =
          core::drawMatches(left_image->image, right_image->image, matches, selection.mask,
                            errors(pending, matches), tolerance_, max_lines_);
      publisher_.publish(
          cv_bridge::CvImage(pending.left->header, sensor_msgs::image_encodings::BGR8, picture).toImageMsg());
    } catch (const std::exception& error) {  // malformed messages, unsupported encodings, OpenCV
      if (warnings_.due()) NODELET_WARN_STREAM("not drawn: " << error.what());
    }
    pending.selection.reset();  // another selector may still answer
  }

  /// Empty where the truth is not known.
  static std::vector<double> errors(const Pending& pending, const core::Correspondences& matches) {
    if (!pending.truth) return {};
    const core::GroundTruth truth = fromMsg(*pending.truth);
    if (truth.kind == core::TruthKind::kNone) return {};
    return core::groundTruthErrors(truth, matches);
  }

  CallbackThread thread_;   ///< one callback at a time: no locks around the caches
  double tolerance_ = 5.0;  ///< px, up to which a match counts as right
  std::size_t max_lines_ = 200;
  std::uint32_t queue_size_ = 5;
  std::unique_ptr<StampCache<Pending>> pending_;
  std::unique_ptr<StampCache<sensor_msgs::ImageConstPtr>> right_images_;
  std::unique_ptr<image_transport::ImageTransport> transport_;
  std::unique_ptr<OnDemand> demand_;
  image_transport::Publisher publisher_;
  WallThrottle warnings_{5.0};
  std::unique_ptr<ImageSubscriber> left_, right_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::MatchViewerNodelet, nodelet::Nodelet)
