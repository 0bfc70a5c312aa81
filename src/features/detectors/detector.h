#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/features/features.h"
#include "features/detectors/detector_options.h"

namespace corrsel::core {

/// Says whether a keypoint may lie at a place, px of the image that the detector sees.
using PlaceFilter = std::function<bool(const cv::Point2f& place)>;

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

  /// detect() without the keypoints that `allowed` refuses. Those who keep the strongest max_features
  /// themselves must override it, since the refused ones do not count; others may, to save work.
  virtual void detectWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                           Features& features) const;

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

  /// As detectWhere(), with descriptors.
  virtual void detectAndDescribeWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                                      Features& features) const;
};

/// Strongest first; ties are broken by position, scale and angle, so that threads inside OpenCV cannot
/// reorder them.
bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b);

/// Puts features into the order of the given numbers, dropping those that are not named.
void reorder(const std::vector<int>& order, Features& features);

/// Drops the features at places that are not allowed.
void dropRefused(const PlaceFilter& allowed, Features& features);

/// Similarity frames from size and angle: column k is the keypoint's radius along and across its angle.
std::vector<AffineFrame> similarityFrames(const std::vector<cv::KeyPoint>& keypoints);

}  // namespace corrsel::core
