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

/// The name of an image transport that can be used: `wanted`, or "raw" if there is no such transport. In that
/// case the parameter `image_transport` below `pnh` is set to "raw", and an error in the log lists the
/// transports that exist.
std::string usableTransport(const ros::NodeHandle& pnh, const std::string& wanted);

/// Images of one topic, by a transport: "raw", "compressed" or a plug-in of image_transport. Compressed
/// images (TOPIC/compressed, sensor_msgs/CompressedImage) are decoded here, since Debian has no plug-in for
/// them. An image that cannot be decoded is dropped with a throttled warning.
class ImageSubscriber {
 public:
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// Does not subscribe yet.
  /// @param pnh        below which a plug-in looks for its parameters
  /// @param transport  as usableTransport() returns it
  /// @param on_image   called on the queue of `nh`
  ImageSubscriber(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& transport,
                  const std::string& topic, std::uint32_t queue_size, Callback on_image);
  ~ImageSubscriber() { unsubscribe(); }

  /// See LiveSource.
  void subscribe();
  void unsubscribe();

  /// Resolved name, with the part of the transport. Any thread.
  const std::string& topic() const { return topic_; }

  /// Number of connected publishers; 0 while not subscribed. Any thread.
  std::uint32_t publishers() const;

  /// Number of images that could not be decoded, since construction. Any thread.
  std::size_t undecodable() const { return undecodable_; }

 private:
  void decode(const sensor_msgs::CompressedImageConstPtr& msg);

  ros::NodeHandle nh_;
  image_transport::ImageTransport transport_;
  std::string transport_name_;
  image_transport::TransportHints hints_;  ///< made once: a name that becomes unknown later would throw
  std::string base_topic_, topic_;
  std::uint32_t queue_size_;
  Callback on_image_;
  bool subscribed_ = false;
  std::atomic<std::size_t> undecodable_{0};
  WallThrottle warnings_;
  mutable std::mutex mutex_;  ///< guards the handles; they are shut down without it
  image_transport::Subscriber images_;
  ros::Subscriber compressed_images_;
};

}  // namespace corrsel
