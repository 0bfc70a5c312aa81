#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <cstdint>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/camera.h"

namespace corrsel {

/// The calibration of a live camera.
struct Calibration {
  sensor_msgs::CameraInfo info;
  bool rectified = false;  ///< whether the images are rectified
  core::Camera camera;     ///< of the images
};

using CalibrationPtr = std::shared_ptr<const Calibration>;

/// The newest calibration of a camera, from its `camera_info`.
///
/// Nothing waits for it, and it is not synchronised: it is valid for all later images whose size it fits. A
/// change is logged once, and so is a message that is no calibration, with the field, its value and the
/// remedy; the images then have none. Must be called on the queue of the node handle.
class CameraInfoInput {
 public:
  /// Does not subscribe yet.
  /// @param rectified  whether the images are rectified, see cameraOf()
  CameraInfoInput(const ros::NodeHandle& nh, const std::string& topic, bool rectified);
  ~CameraInfoInput() { unsubscribe(); }

  void subscribe();
  void unsubscribe() { subscriber_.shutdown(); }

  /// The calibration that belongs to an image; null where there is none, and where it is for images of
  /// another size, which is logged once.
  CalibrationPtr of(const sensor_msgs::Image& image);

 private:
  void receive(const sensor_msgs::CameraInfo& info);

  ros::NodeHandle nh_;
  std::string topic_;  ///< resolved
  bool rectified_;
  ros::Subscriber subscriber_;
  std::optional<std::vector<std::uint8_t>> content_;  ///< of the newest message, without its header
  CalibrationPtr calibration_;
  cv::Size refused_;  ///< size of images that was logged as another one
};

}  // namespace corrsel
