#include "sender.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>

namespace corrsel::load_test {
namespace {

constexpr std::uint32_t kQueue = 2;
constexpr std::size_t kStay = 100;  ///< images of a sequence that show one pair's scene

/// A camera without distortion whose focal length is the width of the image.
sensor_msgs::CameraInfo infoOf(const sensor_msgs::Image& image) {
  sensor_msgs::CameraInfo info;
  info.header = image.header;
  info.width = image.width;
  info.height = image.height;
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0.0);
  const double focal_length = image.width;
  info.K = {focal_length, 0, image.width / 2.0, 0, focal_length, image.height / 2.0, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {focal_length, 0, image.width / 2.0, 0, 0, focal_length, image.height / 2.0, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace

Sender::Sender(ros::NodeHandle& nh, const Arguments& arguments)
    : images_(loadImages(arguments)),
      sequence_(arguments.sequence),
      calibrated_(arguments.calibrated),
      mask_period_(arguments.mask_period) {
  const std::vector<std::string> prefixes =
      sequence_ ? std::vector<std::string>{""} : std::vector<std::string>{"left/", "right/"};
  for (const std::string& prefix : prefixes) {
    Camera camera;
    camera.image = nh.advertise<sensor_msgs::Image>(prefix + "image", kQueue);
    if (mask_period_ > 0) camera.mask = nh.advertise<sensor_msgs::Image>(prefix + "mask", kQueue);
    if (calibrated_) camera.info = nh.advertise<sensor_msgs::CameraInfo>(prefix + "camera_info", kQueue);
    cameras_.push_back(camera);
  }
}

void Sender::send(const ros::Time& stamp) {
  const std::size_t frame = next_++;
  StereoImages& pair = images_[(sequence_ ? frame / kStay : frame) % images_.size()];
  const bool masked = mask_period_ > 0 && frame % static_cast<std::size_t>(mask_period_) == 0;
  if (masked && !before_.isZero()) {
    for (const Camera& camera : cameras_) sendMask(camera, pair.left);
  }
  if (sequence_) {
    sendImage(cameras_[0], frame % 2 == 0 ? pair.left : pair.right, stamp);
  } else {
    sendImage(cameras_[0], pair.left, stamp);
    sendImage(cameras_[1], pair.right, stamp);
  }
  before_ = stamp;
}

void Sender::sendImage(const Camera& camera, sensor_msgs::Image& image, const ros::Time& stamp) const {
  image.header.stamp = stamp;
  if (calibrated_) camera.info.publish(infoOf(image));
  camera.image.publish(image);
}

/// Excludes the lower quarter.
void Sender::sendMask(const Camera& camera, const sensor_msgs::Image& image) const {
  sensor_msgs::Image mask;
  mask.header = image.header;
  mask.header.stamp = before_;
  mask.width = mask.step = image.width;
  mask.height = image.height;
  mask.encoding = sensor_msgs::image_encodings::MONO8;
  mask.data.assign(static_cast<std::size_t>(mask.width) * mask.height, 255);
  std::fill(mask.data.begin() + static_cast<std::ptrdiff_t>(mask.data.size() / 4 * 3), mask.data.end(), 0);
  camera.mask.publish(mask);
}

std::string Sender::missing() const {
  std::string text;
  for (const Camera& camera : cameras_) {
    if (camera.image.getNumSubscribers() > 0) continue;
    text += (text.empty() ? "" : ", ") + ("no node subscribes to " + camera.image.getTopic());
  }
  return text;
}

std::string Sender::topics() const {
  std::string text;
  for (const Camera& camera : cameras_) text += (text.empty() ? "" : " and ") + camera.image.getTopic();
  return text;
}

std::string Sender::text() const {
  const sensor_msgs::Image& first = images_[0].left;
  return std::to_string(images_.size()) + " pairs" + (sequence_ ? ", as a sequence" : "") +
         ", the first of " + std::to_string(first.width) + "x" + std::to_string(first.height) + " " +
         first.encoding + (calibrated_ ? ", calibrated" : "") +
         (mask_period_ > 0 ? ", a mask for every " + std::to_string(mask_period_) + ". image" : "") +
         ", on " + topics();
}

}  // namespace corrsel::load_test
