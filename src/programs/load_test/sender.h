#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/time.h>
#include <sensor_msgs/CameraInfo.h>

#include <cstddef>
#include <string>
#include <vector>

#include "arguments.h"
#include "images.h"

namespace corrsel::load_test {

/// Publishes what cameras publish: the images of two cameras or, as a sequence, of one, and where the
/// arguments ask for them masks and calibrations. A sequence shows the left and the right image of a pair in
/// turn, a hundred times, then those of the next pair.
class Sender {
 public:
  Sender(ros::NodeHandle& nh, const Arguments& arguments);

  /// Publishes the next images. Masks are late by one image: they have the stamp of the call before.
  void send(const ros::Time& stamp);

  /// Names the topics that nobody subscribes to; empty if all are received.
  std::string missing() const;

  std::string topics() const;

  /// What is played, in words.
  std::string text() const;

 private:
  struct Camera {
    ros::Publisher image, mask, info;
  };

  void sendImage(const Camera& camera, sensor_msgs::Image& image, const ros::Time& stamp) const;
  void sendMask(const Camera& camera, const sensor_msgs::Image& image) const;

  std::vector<StereoImages> images_;
  const bool sequence_, calibrated_;
  const int mask_period_;  ///< images from one mask to the next; 0 = none
  std::vector<Camera> cameras_;
  std::size_t next_ = 0;
  ros::Time before_;  ///< stamp of the newest images
};

}  // namespace corrsel::load_test
