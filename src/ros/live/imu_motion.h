#pragma once

#include <ros/subscriber.h>
#include <sensor_msgs/Imu.h>

#include <atomic>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/gyroscope.h"
#include "ros/live/callback_thread.h"
#include "ros/live/motion_source.h"
#include "ros/live/transforms.h"

namespace corrsel {

/// The rotation of the camera from the angular rates on `imu` (sensor_msgs/Imu). The rotation from the frame
/// of the IMU to that of the camera is `imu_rotation` or, where this is empty, comes from TF.
class ImuMotion : public MotionSource {
 public:
  /// Does not subscribe yet.
  ImuMotion(const ros::NodeHandle& nh, const FeatureMatcherParameters& parameters);
  ~ImuMotion() override { unsubscribe(); }

  void subscribe() override;
  void unsubscribe() override;
  std::string name() const override { return "the gyroscope"; }
  std::vector<std::string> topics() const override { return {nh_.resolveName("imu")}; }
  Inputs inputs() const override { return {{"imu", received_}}; }

 private:
  std::optional<core::MotionGuess> find(const CameraMoment& left, const CameraMoment& right,
                                        std::string& why_missing) override;
  bool mayCome(const CameraMoment& left, const CameraMoment& right) const override;
  void receive(const sensor_msgs::Imu& message);
  std::optional<cv::Matx33d> cameraFromImu(const std::string& camera_frame, std::string& why_missing);

  const double sigma_;  ///< beside that of the gyroscope, rad
  std::optional<cv::Matx33d> camera_from_imu_;
  CallbackThread thread_;
  ros::NodeHandle nh_;
  TransformInput transforms_;  ///< subscribed where camera_from_imu_ is not given
  std::atomic<std::size_t> received_{0};
  mutable std::mutex mutex_;  ///< guards what follows
  core::Gyroscope gyroscope_;
  std::string imu_frame_;
  std::string fault_;  ///< why the newest message could not be used
  ros::Subscriber subscriber_;
};

}  // namespace corrsel
