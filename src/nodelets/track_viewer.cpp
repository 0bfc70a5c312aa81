#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>
#include <sensor_msgs/image_encodings.h>

#include <memory>
#include <opencv2/core/types.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/Tracks.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/tracking/track_drawing.h"
#include "ros/live/callback_thread.h"
#include "ros/live/image_subscriber.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/on_demand.h"
#include "ros/live/parameters.h"
#include "ros/live/stamp_cache.h"
#include "ros/live/wall_throttle.h"

namespace corrsel {

/// Draws the tracks of a sequence on `tracks/image`, but only while somebody subscribes. Images and `tracks`
/// are brought together by their stamps.
class TrackViewerNodelet : public nodelet::Nodelet {
 public:
  ~TrackViewerNodelet() override { thread_.stop(); }

 private:
  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    for (const std::string& text : readParameters(pnh, parameters_)) NODELET_ERROR_STREAM(text);
    const auto cache_size = static_cast<std::size_t>(parameters_.cache_size);
    images_ = std::make_unique<StampCache<sensor_msgs::ImageConstPtr>>(cache_size);
    drawing_ = std::make_unique<core::TrackDrawing>(static_cast<std::size_t>(parameters_.tail));
    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    transport_ = std::make_unique<image_transport::ImageTransport>(nh);
    image_input_ = std::make_unique<ImageSubscriber>(
        nh, pnh, usableTransport(pnh, parameters_.image_transport), "image", queueSize(),
        [this](const sensor_msgs::ImageConstPtr& message) { onImage(message); });
    if (parameters_.lazy) {
      NODELET_INFO("lazy: nothing is subscribed or drawn until somebody subscribes to tracks/image");
    }
    demand_ = std::make_unique<OnDemand>(
        parameters_.lazy, [this] { return publisher_.getNumSubscribers() > 0; }, [this] { subscribe(); },
        [this] { unsubscribe(); });
    const auto on_change = [this](const image_transport::SingleSubscriberPublisher&) { demand_->update(); };
    demand_->start([&] { publisher_ = transport_->advertise("tracks/image", 1, on_change, on_change); });
  }

  std::uint32_t queueSize() const { return static_cast<std::uint32_t>(parameters_.subscriber_queue_size); }

  void subscribe() {
    tracks_input_ = thread_.handle(getNodeHandle())
                        .subscribe<Tracks>("tracks", queueSize(),
                                           [this](const TracksConstPtr& message) { onTracks(message); });
    image_input_->subscribe();
  }

  void unsubscribe() {
    image_input_->unsubscribe();
    tracks_input_.shutdown();
    drawing_->reset();
    tracks_.reset();
  }

  void onImage(const sensor_msgs::ImageConstPtr& message) {
    (*images_)[message->header.stamp] = message;
    if (tracks_ && tracks_->header.stamp == message->header.stamp) draw(message);
  }

  void onTracks(const TracksConstPtr& message) {
    if (tracks_ && message->header.stamp < tracks_->header.stamp) drawing_->reset();  // a bag in a loop
    tracks_ = message;
    try {
      drawing_->add(message->id, pointsOf(*message));
    } catch (const std::invalid_argument& error) {  // a malformed message
      if (warnings_.due()) NODELET_WARN_STREAM("not drawn: Tracks message: " << error.what());
      return;
    }
    const sensor_msgs::ImageConstPtr* image = images_->find(message->header.stamp);
    if (image != nullptr) draw(*image);
  }

  static std::vector<cv::Point2f> pointsOf(const Tracks& message) {
    if (message.x.size() != message.y.size()) throw std::invalid_argument("x and y differ in length");
    std::vector<cv::Point2f> points(message.x.size());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = {message.x[i], message.y[i]};
    return points;
  }

  void draw(const sensor_msgs::ImageConstPtr& message) {
    try {
      const cv::Mat picture = drawing_->draw(fromMsg(message)->image);
      publisher_.publish(
          cv_bridge::CvImage(message->header, sensor_msgs::image_encodings::BGR8, picture).toImageMsg());
    } catch (const std::exception& error) {  // unsupported encodings, OpenCV
      if (warnings_.due()) NODELET_WARN_STREAM("not drawn: " << error.what());
    }
  }

  CallbackThread thread_;  ///< one callback at a time, so that no locks are needed; first: see CallbackThread
  TrackViewerParameters parameters_;
  std::unique_ptr<StampCache<sensor_msgs::ImageConstPtr>> images_;
  std::unique_ptr<core::TrackDrawing> drawing_;
  TracksConstPtr tracks_;  ///< the newest
  std::unique_ptr<image_transport::ImageTransport> transport_;
  std::unique_ptr<OnDemand> demand_;
  image_transport::Publisher publisher_;
  WallThrottle warnings_;
  std::unique_ptr<ImageSubscriber> image_input_;
  ros::Subscriber tracks_input_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::TrackViewerNodelet, nodelet::Nodelet)
