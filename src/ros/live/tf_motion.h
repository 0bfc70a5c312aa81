#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ros/live/callback_thread.h"
#include "ros/live/motion_source.h"
#include "ros/live/transforms.h"

namespace corrsel {

/// The motion of the camera from TF: between the frames of both images at one time, as of two cameras on a
/// robot, or through `prior_fixed_frame` between two times. The direction of the translation is part of it
/// where it is longer than what TF may be wrong by.
class TfMotion : public MotionSource {
 public:
  /// Does not subscribe yet.
  TfMotion(const ros::NodeHandle& nh, const FeatureMatcherParameters& parameters);

  void subscribe() override { transforms_.subscribe(); }
  void unsubscribe() override { transforms_.unsubscribe(); }
  std::string name() const override { return "TF"; }
  std::vector<std::string> topics() const override { return {"/tf"}; }
  Inputs inputs() const override { return {}; }

 private:
  std::optional<core::MotionGuess> find(const CameraMoment& left, const CameraMoment& right,
                                        std::string& why_missing) override;
  bool mayCome(const CameraMoment&, const CameraMoment&) const override { return true; }

  const double sigma_;            ///< rad
  const double min_translation_;  ///< m
  const std::string frame_, fixed_frame_;
  CallbackThread thread_;
  TransformInput transforms_;
};

}  // namespace corrsel
