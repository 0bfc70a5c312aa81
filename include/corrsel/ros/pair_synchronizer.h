#pragma once

#include <image_transport/image_transport.h>
#include <image_transport/subscriber_filter.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/sync_policies/exact_time.h>
#include <message_filters/synchronizer.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace corrsel {

/// Brings `left/image` and `right/image` together by their stamps. Private parameters: `approximate_sync`
/// (false), `approximate_sync_max_interval` (s, 0 = no limit), `queue_size` (5, of the synchroniser),
/// `subscriber_queue_size` (1, of each topic), `image_transport` (raw).
class PairSynchronizer {
 public:
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&, const sensor_msgs::ImageConstPtr&)>;

  /// Subscribes to nothing yet. @param on_pair  called on the queue of `nh`
  PairSynchronizer(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, Callback on_pair);

  void subscribe();
  void unsubscribe();

  std::string leftTopic() const { return left_.getTopic(); }
  std::string rightTopic() const { return right_.getTopic(); }

  /// Why pairs do not form, with counts, topics and cures; empty where they do, or where nothing arrives.
  /// Counts from the call before; safe on another thread.
  std::string misses();

 private:
  using Image = sensor_msgs::Image;
  using ExactPolicy = message_filters::sync_policies::ExactTime<Image, Image>;
  using ApproximatePolicy = message_filters::sync_policies::ApproximateTime<Image, Image>;

  ros::NodeHandle pnh_;
  Callback on_pair_;
  std::uint32_t queue_size_;
  bool subscribed_ = false;
  std::atomic<std::size_t> n_left_{0}, n_right_{0}, n_pairs_{0};
  // Order of destruction: the synchronisers first, then their inputs, then what the inputs use.
  image_transport::ImageTransport transport_;
  image_transport::SubscriberFilter left_, right_;
  std::unique_ptr<message_filters::Synchronizer<ExactPolicy>> exact_;
  std::unique_ptr<message_filters::Synchronizer<ApproximatePolicy>> approximate_;
};

}  // namespace corrsel
