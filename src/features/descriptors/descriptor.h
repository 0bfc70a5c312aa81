#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

/// Describes the surroundings of keypoints. describe() is const and re-entrant.
class Descriptor {
 public:
  virtual ~Descriptor() = default;

  /// Sets features.descriptors, one row per keypoint: CV_32F (compared by L2) or CV_8U (compared by Hamming
  /// distance). Features that cannot be described, e.g. too near to the border, are removed with their
  /// frames; the order of the others is kept.
  /// @param grey      the image that the features were found in: 8-bit, one channel
  /// @param threads   threads that may be used; the result does not depend on it
  /// @param features  keypoints and frames, one each
  virtual void describe(const cv::Mat& grey, int threads, Features& features) const = 0;

  /// As in "detector+descriptor".
  virtual std::string name() const = 0;

  virtual const OptionSet& options() const = 0;
};

/// Keeps the features whose flag is not 0, with their frames, in order; descriptors are left alone.
void keepFeatures(const std::vector<char>& keep, Features& features);

}  // namespace corrsel::core
