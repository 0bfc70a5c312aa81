#include "ros/live/image_subscriber.h"

#include <cv_bridge/cv_bridge.h>
#include <image_transport/image_transport.h>
#include <ros/console.h>
#include <sensor_msgs/image_encodings.h>

#include <exception>
#include <utility>

#include "corrsel/ros/conversions.h"

namespace corrsel {
namespace {

constexpr double kWarningPeriod = 5.0;  // s
const char* const kPackage = "image_transport/";

}  // namespace

std::string usableTransport(const ros::NodeHandle& pnh, const std::string& wanted) {
  if (wanted == "raw" || wanted == "compressed") return wanted;
  std::string known = "raw, compressed";
  for (std::string name : image_transport::ImageTransport(pnh).getLoadableTransports()) {
    if (name.rfind(kPackage, 0) == 0) name.erase(0, std::string(kPackage).size());
    if (name == wanted) return wanted;
    if (name != "raw" && name != "compressed") known += ", " + name;
  }
  ROS_ERROR_STREAM("parameter " << pnh.resolveName("image_transport") << " = '" << wanted
                                << "' is unknown; use one of " << known << ". raw is used now.");
  pnh.setParam("image_transport", "raw");
  return "raw";
}

ImageSubscriber::ImageSubscriber(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                 const std::string& transport, const std::string& topic,
                                 std::uint32_t queue_size, Callback on_image)
    : nh_(nh),
      transport_name_(transport),
      hints_(transport_name_, ros::TransportHints(), pnh),
      base_topic_(topic),
      topic_(nh_.resolveName(topic)),
      queue_size_(queue_size),
      on_image_(std::move(on_image)),
      warnings_(kWarningPeriod) {
  if (transport_name_ != "raw") topic_ += "/" + transport_name_;
  if (transport_name_ != "compressed") loadPlugin();
}

void ImageSubscriber::loadPlugin() {
  try {
    loader_ = std::make_unique<PluginLoader>("image_transport", "image_transport::SubscriberPlugin");
    plugin_ = loader_->createInstance(image_transport::SubscriberPlugin::getLookupName(transport_name_));
  } catch (const pluginlib::PluginlibException& error) {
    ROS_ERROR_STREAM(topic_ << ": the image transport '" << transport_name_
                            << "' cannot be loaded: " << error.what());
    throw;
  }
}

void ImageSubscriber::subscribe() {
  if (subscribed_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (plugin_) {
    plugin_->subscribe(
        nh_, base_topic_, queue_size_, [this](const sensor_msgs::ImageConstPtr& msg) { on_image_(msg); }, {},
        hints_);
  } else {
    compressed_images_ = nh_.subscribe<sensor_msgs::CompressedImage>(
        topic_, queue_size_, [this](const sensor_msgs::CompressedImageConstPtr& msg) { decode(msg); });
  }
  subscribed_ = true;
}

void ImageSubscriber::unsubscribe() {
  if (!subscribed_) return;
  if (plugin_) {
    plugin_->shutdown();
  } else {
    compressed_images_.shutdown();
  }
  subscribed_ = false;
}

std::uint32_t ImageSubscriber::publishers() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return plugin_ ? plugin_->getNumPublishers() : compressed_images_.getNumPublishers();
}

void ImageSubscriber::decode(const sensor_msgs::CompressedImageConstPtr& msg) {
  namespace enc = sensor_msgs::image_encodings;
  sensor_msgs::ImageConstPtr image;
  try {
    const cv::Mat pixels = fromMsg(*msg);
    const std::string& encoding = pixels.channels() == 1 ? enc::MONO8 : enc::BGR8;
    image = cv_bridge::CvImage(msg->header, encoding, pixels).toImageMsg();
  } catch (const std::exception& error) {
    const std::size_t n = ++undecodable_;
    if (warnings_.due()) ROS_WARN_STREAM(topic_ << ": dropped, " << n << " so far: " << error.what());
    return;
  }
  on_image_(image);
}

}  // namespace corrsel
