#pragma once

#include "features/descriptors/opencv_descriptor.h"
#include "features/detectors/brisk.h"

namespace corrsel::core {

/// "brisk" for the keypoints of any detector.
///
/// Idea: Comparing the brightness of pairs of smoothed points on concentric rings is fast and does not depend
/// on contrast.
///
/// Algorithm: 60 points; the long-distance pairs give the direction, 512 short-distance pairs give one bit
/// each after the pattern has been rotated and scaled.
///
/// Input: 8-bit grey image and keypoints, whose size is taken as the diameter of a corner's circle of 7 px at
/// scale 1.
///
/// Options: `pattern_scale`; the other BriskOptions belong to the detector.
///
/// Output: 64 bytes per feature, compared by Hamming distance.
///
/// Failure: Features whose pattern leaves the image are removed.
///
/// Cost: O(pixels + features).
///
/// Source: Leutenegger, Chli and Siegwart, ICCV 2011, section 3.2; implementation: OpenCV's features2d.
class BriskDescriptor : public OpenCvDescriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit BriskDescriptor(const BriskOptions& options = {});
  const OptionSet& options() const override { return options_; }

 private:
  BriskOptions options_;
};

}  // namespace corrsel::core
