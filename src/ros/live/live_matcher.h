#pragma once

#include <boost/shared_ptr.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>

#include "corrsel/Correspondences.h"
#include "corrsel/Features.h"
#include "corrsel/features/extractor.h"
#include "corrsel/features/image_quality_meter.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "corrsel/ros/features.h"
#include "corrsel/tracking/flow_matcher.h"
#include "ros/live/frame_matching.h"
#include "ros/live/image_mask.h"
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
    /// Follows the points of a sequence, in place of the comparison of descriptors; null = none does.
    std::shared_ptr<core::FlowMatcher> flow;
    cv::Rect area;  ///< part of both images in which features are looked for, px; no width or height = up to
                    ///< the edge
  };

  /// What a LiveMatcher does with every image, from its start on.
  struct Setup {
    int threads = 1;      ///< that may be used; the result does not depend on it
    bool quality = true;  ///< measure what the images suffer from, in the part where features are looked
                          ///< for; without it, only their texture is known
    MotionSource* motion = nullptr;  ///< what is known of the motion between the images; null = nothing. It
                                     ///< must outlive this object
    cv::Mat left_mask = {};   ///< where no features are looked for in any left image, see ImageMask; empty =
                              ///< none
    cv::Mat right_mask = {};  ///< the same for right images; a sequence has left ones only
  };

  explicit LiveMatcher(const Setup& setup)
      : threads_(setup.threads),
        measures_quality_(setup.quality),
        motion_(setup.motion),
        left_mask_(setup.left_mask),
        right_mask_(setup.right_mask) {}

  /// Matches the images. Throws std::exception that names the encoding or the size of an image or a mask that
  /// cannot be used.
  /// @return null if there is no earlier image yet
  boost::shared_ptr<Correspondences> match(const ImageSet& images, const Settings& settings);

  /// The features of the newest image of a sequence; null before the first one. O(features).
  boost::shared_ptr<Features> newestFeatures() const;

  /// What became of the guesses of the motion so far.
  const GuessStatistics& guesses() const { return guesses_; }

 private:
  boost::shared_ptr<Correspondences> matchPair(const ImageSet& images, const Settings& settings);
  boost::shared_ptr<Correspondences> matchSequence(const ImageSet& images, const Settings& settings);
  void followSettings(const Settings& settings, const ros::Time& stamp);
  Matching matchingOf(const Settings& settings);
  void countBits(const cv::Mat& image);

  cv::Mat inUsedBits(const cv::Mat& image) const;

  core::ImageQuality qualityOf(const cv::Mat& image, const core::FeatureRegion& region,
                               const ros::Time& stamp, const core::Features& features,
                               core::ImageQualityMeter& meter) const;

  const int threads_;
  const bool measures_quality_;
  MotionSource* const motion_;
  core::ImageQualityMeter left_meter_, right_meter_;  ///< the left one also measures the camera of a sequence
  ImageMask left_mask_, right_mask_;
  GuessStatistics guesses_;
  int bits_ = 8;  ///< of images of 16 bits, so far
  SequenceMatching sequence_;
  std::shared_ptr<const core::FeatureExtractor> sequence_extractor_;  ///< of the features in sequence_
  std::shared_ptr<core::FlowMatcher> sequence_flow_;                  ///< of the points in sequence_
  ros::Time newest_stamp_;                                            ///< of the newest frame
  std::shared_ptr<const core::Features> newest_;                      ///< of that frame
  FeatureInfo newest_info_;
};

/// Which cameras a message has, for diagnostics: "left pinhole, right fisheye, a rig" or "left unknown, right
/// unknown".
std::string camerasText(const Correspondences& message);

}  // namespace corrsel
