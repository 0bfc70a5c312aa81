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
#include "ros/live/camera_info_input.h"
#include "ros/live/image_subscriber.h"
#include "ros/live/nodelet_parameters.h"

namespace corrsel {

/// One camera: its images, its newest latched mask and calibration, and irregularities of its stamps.
class CameraInput {
 public:
  /// @param backwards  whether the stamp is earlier than that of the previous image
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&, bool backwards)>;

  /// Does not subscribe yet.
  /// @param parameters  subscriber_queue_size, image_transport, images, use_mask and
  ///                    mask_mode are used
  /// @param prefix      of the topics `image`, `mask` and `camera_info`: "left/"
  /// @param on_image    called on the queue of `nh`, which must call one callback at a time
  CameraInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
              const FeatureMatcherParameters& parameters, const std::string& prefix, Callback on_image);
  ~CameraInput() { unsubscribe(); }

  void subscribe();
  void unsubscribe();

  const std::string& topic() const { return images_.topic(); }

  /// Newest mask, which is valid for all later images; null = none. A mask without pixels removes it. Must be
  /// called on the queue.
  const sensor_msgs::ImageConstPtr& mask() const { return mask_; }

  /// The calibration of an image of this camera, see CameraInfoInput. Must be called on the queue.
  CalibrationPtr calibration(const sensor_msgs::Image& image) { return camera_info_.of(image); }

  /// Number of images since construction. Any thread.
  std::size_t count() const;

  /// Number of images since the last newPeriod(). Any thread; so are all members below.
  std::size_t periodCount() const;

  /// Stamps of the newest images, oldest first, since the last restart().
  std::vector<ros::Time> recentStamps() const;

  /// Shortest time between two of the recent stamps [s]; 0 with fewer than three.
  double shortestPeriod() const;

  /// Forgets the recent stamps, so that the next image's stamp is not compared with them.
  void restart();

  /// Irregularities of the stamps in this period, or the silence of the camera, which is reported once; empty
  /// = nothing.
  std::string complaint();

  /// "12 left images (/left/image)", with the number of publishers where there are no images.
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
  CameraInfoInput camera_info_;
  ros::Subscriber masks_;
  sensor_msgs::ImageConstPtr mask_;

  mutable std::mutex mutex_;  ///< guards everything below
  bool subscribed_ = false;
  std::size_t count_ = 0;
  Period period_;
  std::deque<ros::Time> recent_;
  core::Stopwatch silence_;  ///< since the last image or subscribe()
  bool silence_reported_ = false;
};

}  // namespace corrsel
