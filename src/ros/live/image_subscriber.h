#pragma once

#include <image_transport/subscriber_plugin.h>
#include <image_transport/transport_hints.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <boost/shared_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <pluginlib/class_loader.hpp>
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
///
/// The plug-in is loaded by the constructor and not by subscribe(). class_loader 2.4 (Debian 12) fails or
/// crashes when two threads load libraries at the same time. A nodelet is constructed on the thread on which
/// its manager loads all nodelets, but it subscribes on a thread of its own.
class ImageSubscriber {
 public:
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// Does not subscribe yet. Throws pluginlib::PluginlibException, after an error in the log, if the
  /// transport cannot be loaded.
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
  using PluginLoader = pluginlib::ClassLoader<image_transport::SubscriberPlugin>;

  void loadPlugin();
  void decode(const sensor_msgs::CompressedImageConstPtr& msg);

  ros::NodeHandle nh_;
  std::string transport_name_;
  image_transport::TransportHints hints_;  ///< where the plug-in finds its parameters
  std::string base_topic_, topic_;
  std::uint32_t queue_size_;
  Callback on_image_;
  bool subscribed_ = false;
  std::atomic<std::size_t> undecodable_{0};
  WallThrottle warnings_;
  mutable std::mutex mutex_;              ///< guards the subscriptions; they are shut down without it
  std::unique_ptr<PluginLoader> loader_;  ///< before the plug-in, whose code it holds; null for "compressed"
  boost::shared_ptr<image_transport::SubscriberPlugin> plugin_;  ///< null for "compressed"
  ros::Subscriber compressed_images_;
};

}  // namespace corrsel
