#include "ros/live/tf_motion.h"

#include <cmath>
#include <opencv2/core.hpp>

namespace corrsel {

TfMotion::TfMotion(const ros::NodeHandle& nh, const FeatureMatcherParameters& parameters)
    : MotionSource(parameters.prior_timeout),
      sigma_(parameters.prior_sigma * M_PI / 180),
      min_translation_(parameters.prior_min_translation),
      frame_(parameters.prior_frame),
      fixed_frame_(parameters.prior_fixed_frame),
      transforms_(thread_.handle(nh)) {}

std::optional<core::MotionGuess> TfMotion::find(const CameraMoment& left, const CameraMoment& right,
                                                std::string& why_missing) {
  CameraMoment from = left, to = right;
  if (!frame_.empty()) from.frame = to.frame = frame_;
  const auto transform = transforms_.between(from, to, fixed_frame_, why_missing);
  if (!transform) return std::nullopt;
  core::MotionGuess guess;
  guess.rotation = transform->rotation;
  guess.rotation_sigma = sigma_;
  const double length = cv::norm(transform->translation);
  if (length > 0 && length >= min_translation_) guess.translation = transform->translation / length;
  return guess;
}

}  // namespace corrsel
