#include "ros/live/pose_motion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "corrsel/Selection.h"
#include "corrsel/ros/pose.h"
#include "geometry/rotation_vector.h"

namespace corrsel {
namespace {

constexpr std::uint32_t kQueue = 10;
constexpr double kMaxAge = 1.0;             // s; a motion before that has ended
constexpr double kMaxDirectionSigma = 0.1;  // rad; a direction that is known less is not used

/// The largest standard deviation of two or three rows of RelativePose::covariance; NaN where one is.
double largestSigma(const RelativePose& message, int begin, int end) {
  double variance = 0;
  for (int k = begin; k < end; ++k) {
    const double value = message.covariance[static_cast<std::size_t>(6 * k)];
    if (std::isnan(value)) return value;
    variance = std::max(variance, value);
  }
  return std::sqrt(variance);
}

}  // namespace

PoseMotion::PoseMotion(const ros::NodeHandle& nh, const FeatureMatcherParameters& parameters)
    : MotionSource(parameters.prior_timeout),
      sigma_(parameters.prior_sigma * M_PI / 180),
      nh_(thread_.handle(nh)) {}

void PoseMotion::subscribe() {
  subscriber_ = nh_.subscribe<RelativePose>(
      "relative_pose", kQueue, [this](const RelativePoseConstPtr& message) { receive(*message); });
}

void PoseMotion::receive(const RelativePose& message) {
  const double time = (message.header.stamp - message.right_stamp).toSec();
  const bool usable = message.status == Selection::STATUS_OK && !message.uncertain && time > 0 &&
                      message.motion != RelativePose::MOTION_NONE;
  const double sigma = largestSigma(message, 0, 3);
  if (!usable || std::isnan(sigma)) return;
  core::Pose pose;
  try {
    pose = fromMsg(message).pose;
  } catch (const std::invalid_argument&) {
    return;  // a message of somebody else that is no pose
  }
  Velocity velocity;
  velocity.stamp = message.header.stamp;
  velocity.frame = message.header.frame_id;
  velocity.rate = core::rotationVector(pose.rotation) / time;
  velocity.sigma = sigma / time;
  if (message.motion == RelativePose::MOTION_GENERAL && largestSigma(message, 3, 5) < kMaxDirectionSigma) {
    velocity.direction = cv::normalize(pose.translation);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (last_ && last_->frame == velocity.frame && last_->stamp < velocity.stamp) {
    velocity.sigma = std::hypot(velocity.sigma, cv::norm(velocity.rate - last_->rate) / std::sqrt(3.0));
  }
  last_ = velocity;
}

std::optional<core::MotionGuess> PoseMotion::find(const CameraMoment& left, const CameraMoment& right,
                                                  std::string& why_missing) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!last_) {
    why_missing = "no pose on relative_pose that is to be relied on; does the selector estimate one?";
    return std::nullopt;
  }
  const double age = left.stamp.toSec() - last_->stamp.toSec();
  if (last_->frame != left.frame || right.frame != left.frame) {
    why_missing = "relative_pose is of the frame '" + last_->frame + "', the images are of '" + left.frame +
                  "' and '" + right.frame + "'";
    return std::nullopt;
  }
  if (!(age >= 0 && age <= kMaxAge)) {
    why_missing = age < 0 ? "the last pose is newer than the image" : "the last pose is too old";
    return std::nullopt;
  }
  const double time = left.stamp.toSec() - right.stamp.toSec();
  core::MotionGuess guess;
  guess.rotation = core::rotationFromVector(last_->rate * time);
  guess.rotation_sigma = std::hypot(sigma_, last_->sigma * time);
  guess.translation = last_->direction;
  return guess;
}

}  // namespace corrsel
