#include "ros/live/camera_input.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/text.h"
#include "corrsel/ros/cameras.h"

namespace corrsel {
namespace {

constexpr std::size_t kRecentStamps = 20;
constexpr double kSilenceSeconds = 5.0;

double seconds(const ros::Time& later, const ros::Time& earlier) {
  // Not as ros::Duration, which throws for differences of more than 68 years.
  return later.toSec() - earlier.toSec();
}

bool areRectified(FeatureMatcherParameters::Images images, const std::string& topic) {
  using Images = FeatureMatcherParameters::Images;
  return images == Images::kAuto ? isRectified("auto", topic) : images == Images::kRectified;
}

}  // namespace

CameraInput::CameraInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                         const FeatureMatcherParameters& parameters, const std::string& prefix,
                         Callback on_image)
    : nh_(nh),
      mask_topic_(prefix + "mask"),
      use_mask_(parameters.use_mask && parameters.mask_mode == MaskMode::kLatched),
      on_image_(std::move(on_image)),
      images_(nh, pnh, parameters.image_transport, prefix + "image",
              static_cast<std::uint32_t>(parameters.subscriber_queue_size),
              [this](const sensor_msgs::ImageConstPtr& msg) { receive(msg); }),
      camera_info_(nh, prefix + "camera_info", areRectified(parameters.images, images_.topic())) {}

void CameraInput::subscribe() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (subscribed_) return;
    subscribed_ = true;
    recent_.clear();
    silence_.restart();
    silence_reported_ = false;
  }
  if (use_mask_) {
    masks_ = nh_.subscribe<sensor_msgs::Image>(mask_topic_, 1, [this](const sensor_msgs::ImageConstPtr& msg) {
      mask_ = msg->data.empty() ? nullptr : msg;
    });
  }
  camera_info_.subscribe();
  images_.subscribe();
}

void CameraInput::unsubscribe() {
  images_.unsubscribe();
  camera_info_.unsubscribe();
  masks_.shutdown();
  const std::lock_guard<std::mutex> lock(mutex_);
  subscribed_ = false;
}

void CameraInput::receive(const sensor_msgs::ImageConstPtr& msg) {
  const ros::Time& stamp = msg->header.stamp;
  bool backwards = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++count_;
    ++period_.images;
    silence_.restart();
    silence_reported_ = false;
    if (stamp.isZero()) ++period_.zero;
    if (!recent_.empty()) {
      if (stamp == recent_.back() && !stamp.isZero()) ++period_.repeated;
      backwards = stamp < recent_.back();
      if (backwards) {
        ++period_.backwards;
        period_.longest_jump = std::max(period_.longest_jump, seconds(recent_.back(), stamp));
        recent_.clear();
      }
    }
    recent_.push_back(stamp);
    if (recent_.size() > kRecentStamps) recent_.pop_front();
  }
  on_image_(msg, backwards);
}

std::size_t CameraInput::count() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return count_;
}

std::size_t CameraInput::periodCount() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return period_.images;
}

std::vector<ros::Time> CameraInput::recentStamps() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {recent_.begin(), recent_.end()};
}

double CameraInput::shortestPeriod() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (recent_.size() < 3) return 0.0;
  double shortest = seconds(recent_[1], recent_[0]);
  for (std::size_t i = 2; i < recent_.size(); ++i) {
    shortest = std::min(shortest, seconds(recent_[i], recent_[i - 1]));
  }
  return shortest;
}

void CameraInput::restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  recent_.clear();
}

std::string CameraInput::complaint() {
  std::vector<std::string> parts;
  bool silent = false;
  double silence = 0.0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::string of = " of " + std::to_string(period_.images);
    if (period_.zero > 0) parts.push_back(std::to_string(period_.zero) + of + " stamps are zero");
    if (period_.repeated > 0) {
      parts.push_back(std::to_string(period_.repeated) + of + " stamps repeat the one before");
    }
    if (period_.backwards > 0) {
      parts.push_back("time went backwards " + std::to_string(period_.backwards) + " times, by up to " +
                      core::formatNumber(std::round(period_.longest_jump * 1e3) / 1e3) +
                      " s (a bag played in a loop, a clock that was set, or two publishers?)");
    }
    silence = silence_.seconds();
    silent = subscribed_ && !silence_reported_ && silence >= kSilenceSeconds;
    silence_reported_ = silence_reported_ || silent;
  }
  if (silent) {
    parts.push_back("no image for " + std::to_string(static_cast<int>(silence)) + " s, " + publishersText());
  }
  return parts.empty() ? "" : topic() + ": " + core::joinList(parts, "; ");
}

std::string CameraInput::describe(const std::string& name) const {
  const std::size_t n = periodCount();
  return std::to_string(n) + " " + name + " images (" + topic() + (n == 0 ? ", " + publishersText() : "") +
         ")";
}

void CameraInput::newPeriod() {
  const std::lock_guard<std::mutex> lock(mutex_);
  period_ = Period();
}

std::string CameraInput::publishersText() const {
  const std::uint32_t n = images_.publishers();
  return n == 0 ? "nobody publishes it" : std::to_string(n) + (n == 1 ? " publisher" : " publishers");
}

}  // namespace corrsel
