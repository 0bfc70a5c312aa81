#pragma once

#include "features/descriptors/opencv_descriptor.h"
#include "features/detectors/orb.h"

namespace corrsel::core {

/// "orb" for the keypoints of any detector: rotated BRIEF.
///
/// Idea: Comparing the brightness of pairs of pixels in a smoothed patch gives one bit each, which is fast to
/// compute and to compare.
///
/// Algorithm: The patch is taken from the pyramid level whose scale is nearest to size / 7 px; 256 learned
/// pairs are rotated by the keypoint's angle.
///
/// Input: 8-bit grey image and keypoints, whose size is taken as the diameter of FAST's circle of 7 px at
/// scale 1.
///
/// Options: `scale_factor`, `levels` and `patch_size`; the other OrbOptions belong to the detector.
///
/// Output: 32 bytes per feature, compared by Hamming distance.
///
/// Failure: Features closer to the border of their level than the patch size are removed.
///
/// Cost: O(pixels + features).
///
/// Source: Rublee, Rabaud, Konolige and Bradski, ICCV 2011, section 4; implementation: OpenCV's features2d.
class OrbDescriptor : public OpenCvDescriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit OrbDescriptor(const OrbOptions& options = {});
  const OptionSet& options() const override { return options_; }

 private:
  OrbOptions options_;
};

}  // namespace corrsel::core
