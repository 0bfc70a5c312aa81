#pragma once

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "corrsel/Correspondences.h"
#include "corrsel/camera.h"
#include "corrsel/features/features.h"
#include "corrsel/matching/guided.h"
#include "corrsel/matching/sequence.h"
#include "corrsel/ros/conversions.h"

namespace corrsel {

/// The features and the calibration of an image.
struct FrameFeatures {
  const core::Features& features;
  std::optional<core::Camera> camera;
};

/// How the features of two images are matched.
struct Matching {
  /// Returns what is believed of the motion between the images before they are matched; empty = never
  /// anything.
  std::function<std::optional<core::MotionGuess>(const FrameFeatures& left, const FrameFeatures& right,
                                                 const PairInfo& info)>
      guess;
  /// Matches the features. @param guess  only where both images have a calibration
  std::function<core::GuidedMatches(const FrameFeatures& left, const FrameFeatures& right,
                                    const std::optional<core::MotionGuess>& guess)>
      match;
};

/// Matches the features and makes the message. Throws what `matching` throws, and std::runtime_error that
/// names the column if what it returns is inconsistent.
/// @param conversion_seconds  spent on the input; it becomes part of seconds.publish
/// @param kept  filled with the matches where not null
boost::shared_ptr<Correspondences> matchFrames(const FrameFeatures& left, const FrameFeatures& right,
                                               const Matching& matching, double conversion_seconds,
                                               PairInfo info, core::Correspondences* kept = nullptr);

/// Matches every frame of one camera with an earlier one, which is the right side of the message. Not
/// thread-safe.
class SequenceMatching {
 public:
  /// A frame of another size, or of a time before that of the earlier one (a bag that starts again), begins a
  /// new sequence. Throws what matchFrames() and core::Sequence throw.
  /// @param info  of the frame, which is the left side; its stamp is that of the frame
  /// @return null if there is no earlier frame yet
  boost::shared_ptr<Correspondences> add(std::shared_ptr<const core::Features> features,
                                         const std::optional<core::Camera>& camera,
                                         const core::SequenceOptions& options, const Matching& matching,
                                         double conversion_seconds, PairInfo info);

  /// Begins a new sequence, e.g. with features of another kind.
  void reset() { sequence_.reset(); }

 private:
  core::Sequence sequence_;
};

}  // namespace corrsel
