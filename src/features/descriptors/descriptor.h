#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/features/features.h"
#include "corrsel/options.h"
#include "corrsel/workspace.h"
#include "features/parts/scale_level.h"

namespace corrsel::core {

/// Describes the surroundings of keypoints. All members are const and re-entrant.
class Descriptor {
 public:
  virtual ~Descriptor() = default;

  /// Sets features.descriptors, one row per keypoint: CV_32F (compared by L2) or CV_8U (compared by Hamming
  /// distance). Features that cannot be described, e.g. those too close to the border, are removed with their
  /// frames; the others keep their order.
  /// @param grey     the image in which the features were found: 8-bit, one channel; it may be a part of
  /// another image
  /// @param threads  threads that may be used; the result does not depend on it
  /// @param workspace  memory for the calling thread; other threads use their own workspaces
  /// @param features  one frame per keypoint, and no descriptors yet
  virtual void describe(const cv::Mat& grey, int threads, Workspace& workspace, Features& features) const = 0;

  /// As describe(), where the detector has a scale space of the image. A descriptor that needs blurred levels
  /// overrides it and uses these instead of its own.
  /// @param levels  at least one, in the order of sigma
  virtual void describeOn(const std::vector<ScaleLevel>& levels, const cv::Mat& grey, int threads,
                          Workspace& workspace, Features& features) const {
    static_cast<void>(levels);
    describe(grey, threads, workspace, features);
  }

  /// The part of "detector+descriptor" after the plus sign.
  virtual std::string name() const = 0;

  virtual const OptionSet& options() const = 0;
};

}  // namespace corrsel::core
