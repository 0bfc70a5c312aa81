#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/time.h>
#include <sensor_msgs/Image.h>

#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "ros/live/image_subscriber.h"

namespace corrsel {

/// One camera: its images, its newest mask, and what is odd about its stamps. Private parameters:
/// `subscriber_queue_size` (5), `image_transport` (raw), `use_mask` (false).
class CameraInput {
 public:
  /// @param backwards  whether the stamp is earlier than that of the image before
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&, bool backwards)>;

  /// Subscribes to nothing yet. @param on_image  called on the queue of `nh`, which calls one at a time
  CameraInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& image_topic,
              const std::string& mask_topic, Callback on_image);
  ~CameraInput() { unsubscribe(); }

  void subscribe();
  void unsubscribe();

  const std::string& topic() const { return images_.topic(); }

  /// Newest mask, which stands for all later images; null = none. A mask without pixels takes it away. To be
  /// called on the queue.
  const sensor_msgs::ImageConstPtr& mask() const { return mask_; }

  /// Images since construction. Any thread.
  std::size_t count() const;

  /// Images since the last newPeriod(). Any thread, as all that follows.
  std::size_t periodCount() const;

  /// Stamps of the newest images, oldest first, since the last restart().
  std::vector<ros::Time> recentStamps() const;

  /// Shortest time between two of the recent stamps [s]; 0 with fewer than three.
  double shortestPeriod() const;

  /// Forgets the recent stamps: the next image's is not compared with them.
  void restart();

  /// What has been odd about the stamps in this period, or that the camera is silent, which is said once;
  /// empty = nothing.
  std::string complaint();

  /// "12 images (/left/image)", with who publishes it where there are none.
  std::string describe(const std::string& name) const;

  void newPeriod();

 private:
  struct Period {
    std::size_t images = 0, zero = 0, repeated = 0, backwards = 0;
    double longest_jump = 0.0;  ///< s, backwards
  };

  void receive(const sensor_msgs::ImageConstPtr& msg);
  std::string publishersText() const;

  ros::NodeHandle nh_;
  std::string mask_topic_;
  bool use_mask_;
  Callback on_image_;
  ImageSubscriber images_;
  ros::Subscriber masks_;
  sensor_msgs::ImageConstPtr mask_;

  mutable std::mutex mutex_;  ///< guards all below
  bool subscribed_ = false;
  std::size_t count_ = 0;
  Period period_;
  std::deque<ros::Time> recent_;
  core::Stopwatch silence_;  ///< since the last image or subscribe()
  bool silence_told_ = false;
};

}  // namespace corrsel
