#include "ros/live/camera_info_input.h"

#include <ros/console.h>
#include <ros/serialization.h>

#include <stdexcept>
#include <utility>

#include "base/size_text.h"
#include "base/text.h"
#include "corrsel/ros/cameras.h"

namespace corrsel {
namespace {

/// The bytes of a camera_info without its header, of which only frame and stamp may differ from message to
/// message. Unlike the numbers, they are equal also where there is NaN.
std::vector<std::uint8_t> contentOf(sensor_msgs::CameraInfo info) {
  info.header = std_msgs::Header();
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(info));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, info);
  return bytes;
}

}  // namespace

CameraInfoInput::CameraInfoInput(const ros::NodeHandle& nh, const std::string& topic, bool rectified)
    : nh_(nh), topic_(nh_.resolveName(topic)), rectified_(rectified) {}

void CameraInfoInput::subscribe() {
  subscriber_ = nh_.subscribe<sensor_msgs::CameraInfo>(
      topic_, 1, [this](const sensor_msgs::CameraInfoConstPtr& msg) { receive(*msg); });
}

void CameraInfoInput::receive(const sensor_msgs::CameraInfo& info) {
  std::vector<std::uint8_t> content = contentOf(info);
  if (content_ == content) return;
  const bool first = !content_;
  content_ = std::move(content);
  calibration_.reset();
  refused_ = cv::Size();
  try {
    const core::Camera camera = cameraOf(info, rectified_);
    calibration_ = std::make_shared<const Calibration>(Calibration{info, rectified_, camera});
    ROS_INFO_STREAM("camera_info on " << topic_ << (first ? ": " : " has changed: ")
                                      << core::toString(camera.model) << ", " << core::sizeText(camera.size)
                                      << " px, focal length " << core::formatNumber(camera.matrix(0, 0))
                                      << " px" << (rectified_ ? ", of rectified images" : ", of raw images"));
  } catch (const std::invalid_argument& error) {
    ROS_WARN_STREAM("camera_info on " << topic_ << ": " << error.what()
                                      << ". Until then, its images are matched without a calibration");
  }
}

CalibrationPtr CameraInfoInput::of(const sensor_msgs::Image& image) {
  if (!calibration_) return nullptr;
  const cv::Size size(static_cast<int>(image.width), static_cast<int>(image.height));
  if (calibration_->camera.size == size) return calibration_;
  if (refused_ != size) {
    refused_ = size;
    ROS_WARN_STREAM("camera_info on "
                    << topic_ << " is for images of " << core::sizeText(calibration_->camera.size)
                    << " px (width and height, less region of interest and binning), the image has "
                    << core::sizeText(size)
                    << " px: publish the camera_info that belongs to the images. Until then, "
                       "its images are matched without a calibration");
  }
  return nullptr;
}

}  // namespace corrsel
