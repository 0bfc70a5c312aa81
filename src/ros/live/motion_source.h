#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "base/stopwatch.h"
#include "corrsel/motion_guess.h"
#include "ros/live/live_source.h"
#include "ros/live/nodelet_parameters.h"

namespace corrsel {

/// A moment of a camera.
struct CameraMoment {
  ros::Time stamp;
  std::string frame;
};

/// Where it is known from how a camera has moved, before its images are matched: the angular rates of
/// `sensor_msgs/Imu`, TF, or the last relative pose. What arrives is received on a thread of its own, so that
/// many messages delay no image.
class MotionSource : public LiveSource {
 public:
  /// @param timeout  s of wall time that between() waits at most
  explicit MotionSource(double timeout) : timeout_(timeout) {}

  /// For messages: "the gyroscope".
  virtual std::string name() const = 0;

  /// The motion between two images, as MotionGuess defines it. What is not known yet is awaited until the
  /// timeout; after it has passed in vain, nothing is awaited for a second, so that a source that is silent
  /// or always late costs no time. Calls must come one at a time.
  /// @param why_missing  filled where the motion is not known
  std::optional<core::MotionGuess> between(const CameraMoment& left, const CameraMoment& right,
                                           std::string& why_missing);

 protected:
  /// The motion as far as it is known now.
  virtual std::optional<core::MotionGuess> find(const CameraMoment& left, const CameraMoment& right,
                                                std::string& why_missing) = 0;

  /// Whether messages that are still to come may make it known.
  virtual bool mayCome(const CameraMoment& left, const CameraMoment& right) const = 0;

 private:
  const double timeout_;
  std::optional<core::Stopwatch> in_vain_;  ///< since the timeout last passed in vain
};

/// Opens what the parameters ask for; null for Prior::kNone. It does not subscribe yet.
std::unique_ptr<MotionSource> openMotionSource(const ros::NodeHandle& nh,
                                               const FeatureMatcherParameters& parameters);

/// Two sources that are subscribed together, e.g. the images and what is known of their motion.
class JointSource : public LiveSource {
 public:
  /// @param with  must outlive this object
  JointSource(std::unique_ptr<LiveSource> source, LiveSource& with)
      : source_(std::move(source)), with_(with) {}
  ~JointSource() override { with_.unsubscribe(); }

  void subscribe() override;
  void unsubscribe() override;
  std::vector<std::string> topics() const override { return source_->topics(); }
  Inputs inputs() const override;
  std::string complaint() override { return source_->complaint(); }

 private:
  std::unique_ptr<LiveSource> source_;
  LiveSource& with_;
};

/// What became of the guesses of a MotionSource. Not thread-safe.
class GuessStatistics {
 public:
  /// A guess was used for matching.
  void used(core::GuessVerdict verdict);

  /// There was none.
  void missing(const std::string& reason);

  /// For diagnostics: "confirmed 120, contradicted 2, not tested 0, missing 3 (no camera_info)".
  std::string text() const;

  /// Not empty where most of the last guesses were contradicted; it follows MotionSource::name().
  std::string warning() const;

 private:
  std::size_t confirmed_ = 0, contradicted_ = 0, untested_ = 0, missing_ = 0;
  std::string why_missing_;  ///< the last one
  std::deque<bool> recent_;  ///< whether the last guesses were contradicted
};

}  // namespace corrsel
