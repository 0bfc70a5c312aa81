#include "ros/live/imu_motion.h"

#include <cmath>

#include "base/text.h"

namespace corrsel {
namespace {

constexpr std::uint32_t kQueue = 1000;  // a second at 1000 Hz
constexpr double kRadians = M_PI / 180;

std::int64_t nanoseconds(const ros::Time& stamp) { return static_cast<std::int64_t>(stamp.toNSec()); }

}  // namespace

ImuMotion::ImuMotion(const ros::NodeHandle& nh, const FeatureMatcherParameters& parameters)
    : MotionSource(parameters.prior_timeout),
      sigma_(parameters.prior_sigma * kRadians),
      camera_from_imu_(parameters.imuRotation()),
      nh_(thread_.handle(nh)),
      transforms_(nh_) {}

void ImuMotion::subscribe() {
  if (!camera_from_imu_) transforms_.subscribe();
  subscriber_ = nh_.subscribe<sensor_msgs::Imu>(
      "imu", kQueue, [this](const sensor_msgs::ImuConstPtr& message) { receive(*message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

void ImuMotion::unsubscribe() {
  subscriber_.shutdown();
  transforms_.unsubscribe();
}

void ImuMotion::receive(const sensor_msgs::Imu& message) {
  ++received_;
  const std::lock_guard<std::mutex> lock(mutex_);
  imu_frame_ = message.header.frame_id;
  const auto& rate = message.angular_velocity;
  if (message.angular_velocity_covariance[0] == -1) {  // sensor_msgs/Imu: the rates are not measured
    fault_ = "the messages on imu have no angular velocity (its covariance begins with -1)";
  } else if (message.header.stamp.isZero()) {
    fault_ = "the stamps of the messages on imu are zero";
  } else if (!gyroscope_.add(nanoseconds(message.header.stamp), {rate.x, rate.y, rate.z})) {
    fault_ = "an angular velocity on imu is not finite";
  } else {
    fault_.clear();
  }
}

bool ImuMotion::mayCome(const CameraMoment& left, const CameraMoment& right) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto newest = gyroscope_.newest();
  return newest && *newest < nanoseconds(std::max(left.stamp, right.stamp));
}

std::optional<cv::Matx33d> ImuMotion::cameraFromImu(const std::string& camera_frame,
                                                    std::string& why_missing) {
  if (camera_from_imu_) return camera_from_imu_;
  std::string imu_frame;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    imu_frame = imu_frame_;
  }
  const auto pose =
      transforms_.between({ros::Time(0), imu_frame}, {ros::Time(0), camera_frame}, "", why_missing);
  if (!pose) {
    why_missing += "; set imu_rotation, or publish the transform";
    return std::nullopt;
  }
  return pose->rotation;
}

std::optional<core::MotionGuess> ImuMotion::find(const CameraMoment& left, const CameraMoment& right,
                                                 std::string& why_missing) {
  std::optional<core::Gyroscope::Turn> turn;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    turn = gyroscope_.between(nanoseconds(left.stamp), nanoseconds(right.stamp));
    if (!turn) {
      why_missing = received_ == 0    ? "no message on imu"
                    : !fault_.empty() ? fault_
                                      : "the messages on imu do not cover the time between the images";
      return std::nullopt;
    }
  }
  const auto from_imu = cameraFromImu(left.frame, why_missing);
  if (!from_imu) return std::nullopt;
  core::MotionGuess guess;
  guess.rotation = *from_imu * turn->rotation * from_imu->t();
  guess.rotation_sigma = std::hypot(turn->sigma, sigma_);
  return guess;
}

}  // namespace corrsel
