#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>
#include <sensor_msgs/image_encodings.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/evaluation/errors.h"
#include "corrsel/matching/match_drawing.h"
#include "corrsel/ros/conversions.h"
#include "ros/live/callback_thread.h"
#include "ros/live/image_subscriber.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/on_demand.h"
#include "ros/live/parameters.h"
#include "ros/live/result_collector.h"
#include "ros/live/stamp_cache.h"
#include "ros/live/wall_throttle.h"

namespace corrsel {

/// Draws the decisions of a selector on `matches/image`, but only while somebody subscribes. Images,
/// `correspondences` and `selection` are brought together by their stamps; `ground_truth`, where there is
/// any, gives the colours.
class MatchViewerNodelet : public nodelet::Nodelet {
 public:
  ~MatchViewerNodelet() override { thread_.stop(); }

 private:
  using Result = ResultCollector::Result;

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    for (const std::string& text : readParameters(pnh, parameters_)) NODELET_ERROR_STREAM(text);
    const auto cache_size = static_cast<std::size_t>(parameters_.cache_size);
    results_ = std::make_unique<ResultCollector>(cache_size, [this](Result& result) { draw(result); });
    right_images_ = std::make_unique<StampCache<sensor_msgs::ImageConstPtr>>(cache_size);
    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    transport_ = std::make_unique<image_transport::ImageTransport>(nh);
    const std::string transport = usableTransport(pnh, parameters_.image_transport);
    left_ = std::make_unique<ImageSubscriber>(nh, pnh, transport, "left/image", queueSize(),
                                              [this](const sensor_msgs::ImageConstPtr& msg) { onLeft(msg); });
    right_ =
        std::make_unique<ImageSubscriber>(nh, pnh, transport, "right/image", queueSize(),
                                          [this](const sensor_msgs::ImageConstPtr& msg) { onRight(msg); });

    if (parameters_.lazy) {
      NODELET_INFO("lazy: nothing is subscribed or drawn until somebody subscribes to matches/image");
    }
    demand_ = std::make_unique<OnDemand>(
        parameters_.lazy, [this] { return publisher_.getNumSubscribers() > 0; }, [this] { subscribe(); },
        [this] { unsubscribe(); });
    const auto on_change = [this](const image_transport::SingleSubscriberPublisher&) { demand_->update(); };
    demand_->start([&] { publisher_ = transport_->advertise("matches/image", 1, on_change, on_change); });
  }

  std::uint32_t queueSize() const { return static_cast<std::uint32_t>(parameters_.subscriber_queue_size); }

  void subscribe() {
    results_->subscribe(thread_.handle(getNodeHandle()), queueSize());
    left_->subscribe();
    right_->subscribe();
  }

  void unsubscribe() {
    left_->unsubscribe();
    right_->unsubscribe();
    results_->unsubscribe();
  }

  void onLeft(const sensor_msgs::ImageConstPtr& msg) {
    Result& result = results_->at(msg->header.stamp);
    result.left = msg;
    draw(result);
  }

  void onRight(const sensor_msgs::ImageConstPtr& msg) {
    (*right_images_)[msg->header.stamp] = msg;
    for (auto& entry : *results_) {
      const CorrespondencesConstPtr& correspondences = entry.second.correspondences;
      if (correspondences && correspondences->right_stamp == msg->header.stamp) draw(entry.second);
    }
  }

  void draw(Result& result) {
    if (!result.left || !result.correspondences || result.selections.empty()) return;
    const sensor_msgs::ImageConstPtr* right = right_images_->find(result.correspondences->right_stamp);
    if (right == nullptr) return;
    try {
      const cv_bridge::CvImageConstPtr left_image = fromMsg(result.left);
      const cv_bridge::CvImageConstPtr right_image = fromMsg(*right);
      const core::Correspondences matches = fromMsg(*result.correspondences);
      const core::Selection selection = fromMsg(*result.selections.back());
      if (selection.mask.size() != matches.size()) {
        throw std::invalid_argument("selection and correspondences differ in length");
      }
      const cv::Mat picture = core::drawMatches(
          left_image->image, right_image->image, matches, selection.mask, errors(result, matches),
          parameters_.tolerance, static_cast<std::size_t>(parameters_.max_lines), selection.group,
          selection.motion);
      publisher_.publish(
          cv_bridge::CvImage(result.left->header, sensor_msgs::image_encodings::BGR8, picture).toImageMsg());
    } catch (const std::exception& error) {  // malformed messages, unsupported encodings, OpenCV
      if (warnings_.due()) NODELET_WARN_STREAM("not drawn: " << error.what());
    }
    result.selections.clear();  // the selection of another selector may still come
  }

  /// Empty where the ground truth is not known.
  static std::vector<double> errors(const Result& result, const core::Correspondences& matches) {
    if (!result.truth) return {};
    const core::GroundTruth truth = fromMsg(*result.truth);
    if (truth.kind == core::TruthKind::kNone) return {};
    return core::groundTruthErrors(truth, matches);
  }

  CallbackThread thread_;  ///< one callback at a time, so that no locks are needed; first: see CallbackThread
  MatchViewerParameters parameters_;
  std::unique_ptr<StampCache<sensor_msgs::ImageConstPtr>> right_images_;
  std::unique_ptr<image_transport::ImageTransport> transport_;
  std::unique_ptr<OnDemand> demand_;
  image_transport::Publisher publisher_;
  WallThrottle warnings_;
  std::unique_ptr<ImageSubscriber> left_, right_;
  std::unique_ptr<ResultCollector> results_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::MatchViewerNodelet, nodelet::Nodelet)
