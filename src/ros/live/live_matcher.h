#pragma once

#include <boost/shared_ptr.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "corrsel/Correspondences.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "ros/live/frame_matching.h"
#include "ros/live/image_source.h"
#include "ros/live/motion_source.h"

namespace corrsel {

/// Turns the images of live cameras into messages with putative matches. An image without a partner is
/// matched with an earlier one of the same camera; the newer image is then the left side of the message and
/// the earlier one its right side. The message has the calibrations of the images as they were when each
/// image came, and of a pair the pose between two cameras that were calibrated together.
///
/// Images of 16 bits that use fewer of them are scaled by the number of bits that the largest value so far
/// needed (8, 10, 12, 14 or 16), for all cameras alike. It never falls, so that the scale does not change
/// with the light. Not thread-safe.
class LiveMatcher {
 public:
  struct Settings {
    std::shared_ptr<const core::FeatureExtractor> extractor;
    core::MatchOptions match;
    core::GuidedOptions guided;  ///< where the motion is known
    core::SequenceOptions sequence;
    cv::Rect area;  ///< part of both images in which features are looked for, px; no width or height = up to
                    ///< the edge
  };

  /// @param threads  number of threads that may be used; the result does not depend on it
  /// @param motion   what is known of the motion between the images; null = nothing. It must outlive this
  ///                 object
  explicit LiveMatcher(int threads, MotionSource* motion = nullptr) : threads_(threads), motion_(motion) {}

  /// Matches the images. Throws std::exception that names the encoding or the size of an image or a mask that
  /// cannot be used.
  /// @return null if there is no earlier image yet
  boost::shared_ptr<Correspondences> match(const ImageSet& images, const Settings& settings);

  /// What became of the guesses of the motion so far.
  const GuessStatistics& guesses() const { return guesses_; }

 private:
  boost::shared_ptr<Correspondences> matchPair(const ImageSet& images, const Settings& settings);
  boost::shared_ptr<Correspondences> matchSequence(const ImageSet& images, const Settings& settings);
  Matching matchingOf(const Settings& settings);
  void countBits(const cv::Mat& image);

  cv::Mat inUsedBits(const cv::Mat& image) const;

  const int threads_;
  MotionSource* const motion_;
  GuessStatistics guesses_;
  int bits_ = 8;  ///< of images of 16 bits, so far
  SequenceMatching sequence_;
  std::shared_ptr<const core::FeatureExtractor> sequence_extractor_;  ///< of the features in sequence_
};

/// Which cameras a message has, for diagnostics: "left pinhole, right fisheye, a rig" or "left unknown, right
/// unknown".
std::string camerasText(const Correspondences& message);

}  // namespace corrsel
