#include "ros/live/motion_source.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "base/text.h"
#include "ros/live/imu_motion.h"
#include "ros/live/pose_motion.h"
#include "ros/live/tf_motion.h"

namespace corrsel {
namespace {

constexpr double kPause = 1.0;  // s without waiting after a timeout
constexpr std::chrono::microseconds kPoll(500);
constexpr std::size_t kRecent = 20;

}  // namespace

std::optional<core::MotionGuess> MotionSource::between(const CameraMoment& left, const CameraMoment& right,
                                                       std::string& why_missing) {
  if (left.stamp.isZero() || right.stamp.isZero()) {
    why_missing = "a stamp is zero";
    return std::nullopt;
  }
  const core::Stopwatch watch;
  while (true) {
    const bool may_come = mayCome(left, right);  // before find(), or what comes between the two were missed
    std::optional<core::MotionGuess> guess = find(left, right, why_missing);
    if (guess || !may_come || (in_vain_ && in_vain_->seconds() < kPause)) return guess;
    if (watch.seconds() >= timeout_) {
      in_vain_.emplace();
      return std::nullopt;
    }
    std::this_thread::sleep_for(kPoll);
  }
}

std::unique_ptr<MotionSource> openMotionSource(const ros::NodeHandle& nh,
                                               const FeatureMatcherParameters& parameters) {
  using Prior = FeatureMatcherParameters::Prior;
  switch (parameters.prior) {
    case Prior::kImu:
      return std::make_unique<ImuMotion>(nh, parameters);
    case Prior::kTf:
      return std::make_unique<TfMotion>(nh, parameters);
    case Prior::kLastPose:
      return std::make_unique<PoseMotion>(nh, parameters);
    case Prior::kNone:
      break;
  }
  return nullptr;
}

void JointSource::subscribe() {
  with_.subscribe();
  source_->subscribe();
}

void JointSource::unsubscribe() {
  source_->unsubscribe();
  with_.unsubscribe();
}

LiveSource::Inputs JointSource::inputs() const {
  Inputs inputs = source_->inputs();
  for (auto& input : with_.inputs()) inputs.push_back(std::move(input));
  return inputs;
}

void GuessStatistics::used(core::GuessVerdict verdict) {
  const bool contradicted = verdict == core::GuessVerdict::kContradicted;
  ++(contradicted ? contradicted_ : verdict == core::GuessVerdict::kConfirmed ? confirmed_ : untested_);
  recent_.push_back(contradicted);
  if (recent_.size() > kRecent) recent_.pop_front();
}

void GuessStatistics::missing(const std::string& reason) {
  ++missing_;
  why_missing_ = reason;
}

std::string GuessStatistics::text() const {
  return "confirmed " + std::to_string(confirmed_) + ", contradicted " + std::to_string(contradicted_) +
         ", not tested " + std::to_string(untested_) + ", missing " + std::to_string(missing_) +
         (missing_ > 0 ? " (last: " + why_missing_ + ")" : "");
}

std::string GuessStatistics::warning() const {
  const auto contradicted = std::count(recent_.begin(), recent_.end(), true);
  if (contradicted < static_cast<std::ptrdiff_t>(kRecent / 2)) return "";
  return "contradicts the matches in " + std::to_string(contradicted) + " of the last " +
         std::to_string(recent_.size()) + " pairs: are stamps, frames and imu_rotation right?";
}

}  // namespace corrsel
