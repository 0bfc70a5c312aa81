#pragma once

#include <ros/subscriber.h>

#include <atomic>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/RelativePose.h"
#include "ros/live/callback_thread.h"
#include "ros/live/motion_source.h"

namespace corrsel {

/// The motion of the camera if it goes on as it did: the velocity of the last pose on `relative_pose`, from
/// the Selector, for the time between the images. How much the velocity has changed since the pose before it
/// is part of the uncertainty.
class PoseMotion : public MotionSource {
 public:
  /// Does not subscribe yet.
  PoseMotion(const ros::NodeHandle& nh, const FeatureMatcherParameters& parameters);
  ~PoseMotion() override { unsubscribe(); }

  void subscribe() override;
  void unsubscribe() override { subscriber_.shutdown(); }
  std::string name() const override { return "the last pose"; }
  std::vector<std::string> topics() const override { return {nh_.resolveName("relative_pose")}; }
  Inputs inputs() const override { return {}; }  // a selector that estimates no pose is no silent input

 private:
  struct Velocity {
    ros::Time stamp;  ///< of the newer image
    std::string frame;
    cv::Vec3d rate;                      ///< about axes of the camera, rad/s
    double sigma = 0;                    ///< of rate, rad/s
    std::optional<cv::Vec3d> direction;  ///< of the translation, length 1
  };

  std::optional<core::MotionGuess> find(const CameraMoment& left, const CameraMoment& right,
                                        std::string& why_missing) override;
  bool mayCome(const CameraMoment&, const CameraMoment&) const override { return false; }
  void receive(const RelativePose& message);

  const double sigma_;  ///< rad
  CallbackThread thread_;
  ros::NodeHandle nh_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::optional<Velocity> last_;
  ros::Subscriber subscriber_;
};

}  // namespace corrsel
