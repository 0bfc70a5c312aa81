#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/features/detector_options.h"
#include "corrsel/features/features.h"

namespace corrsel::core {

/// Finds keypoints. detect() is const and re-entrant.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Sets features.keypoints (position and size = diameter in px, angle in degrees, clockwise in the image,
  /// never negative, response: larger is stronger) and features.frames, one per keypoint, whose first axis
  /// (a11, a21) points along the angle. Any order, no cap: the extractor sorts and caps. No features where
  /// the image is too small or blank.
  /// @param grey     8-bit, one channel, not empty
  /// @param threads  threads that may be used; the result does not depend on it
  virtual void detect(const cv::Mat& grey, int threads, Features& features) const = 0;

  /// As in "detector+descriptor".
  virtual std::string name() const = 0;

  virtual const DetectorOptions& options() const = 0;
};

/// A detector with a descriptor of its own, computed in the same pass.
class SelfDescribingDetector : public Detector {
 public:
  /// Like detect(), with descriptors: one row per keypoint. May keep the strongest max_features itself where
  /// that saves work.
  virtual void detectAndDescribe(const cv::Mat& grey, int threads, Features& features) const = 0;
};

/// Similarity frames from size and angle: column k is the keypoint's radius along and across its angle.
std::vector<AffineFrame> similarityFrames(const std::vector<cv::KeyPoint>& keypoints);

}  // namespace corrsel::core
