#pragma once

#include <image_transport/image_transport.h>
#include <image_transport/subscriber.h>
#include <image_transport/transport_hints.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "ros/live/wall_throttle.h"

namespace corrsel {

/// Images of one topic, by the transport that the private parameter `image_transport` names: "raw" (default),
/// "compressed", or a plug-in of image_transport. Compressed images are decoded here, since Debian has no
/// plug-in for them: TOPIC/compressed, sensor_msgs/CompressedImage. What cannot be decoded is dropped with a
/// throttled warning. An unknown transport is an error in the log that lists those there are; raw is used,
/// and written back to the parameter.
class ImageSubscriber {
 public:
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// Subscribes to nothing yet. @param on_image  called on the queue of `nh`
  ImageSubscriber(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& topic,
                  std::uint32_t queue_size, Callback on_image);
  ~ImageSubscriber() { unsubscribe(); }

  /// Both are idempotent and not to be called side by side; see ImageSource::unsubscribe().
  void subscribe();
  void unsubscribe();

  /// Resolved name, with the transport's part. Any thread.
  const std::string& topic() const { return topic_; }

  /// Publishers that are connected; 0 while not subscribed. Any thread.
  std::uint32_t publishers() const;

  /// Images that could not be decoded, since construction. Any thread.
  std::size_t undecodable() const { return undecodable_; }

 private:
  void decode(const sensor_msgs::CompressedImageConstPtr& msg);

  ros::NodeHandle nh_;
  image_transport::ImageTransport transport_;
  std::string transport_name_;
  image_transport::TransportHints hints_;  ///< read once: a name that is unknown later would throw
  std::string base_topic_, topic_;
  std::uint32_t queue_size_;
  Callback on_image_;
  bool subscribed_ = false;
  std::atomic<std::size_t> undecodable_{0};
  WallThrottle warnings_;
  mutable std::mutex mutex_;  ///< guards the handles, which are shut down without it
  image_transport::Subscriber images_;
  ros::Subscriber compressed_images_;
};

}  // namespace corrsel
