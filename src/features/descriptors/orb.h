#pragma once

#include <string>

#include "features/descriptors/descriptor.h"
#include "features/detectors/orb.h"

namespace corrsel::core {

/// "orb" for the keypoints of any detector: rotated BRIEF.
///
/// Idea: Comparing the brightness of pairs of pixels in a smoothed patch gives one bit each, which is fast to
/// compute and to compare.
///
/// Algorithm: The patch is taken from the pyramid level whose scale is nearest to size / 7 px, around the
/// pixel nearest to the keypoint, and described by OrientedPatch with the keypoint's angle.
///
/// Input: 8-bit grey image and keypoints, whose size is taken as the diameter of FAST's circle of 7 px at
/// scale 1.
///
/// Options: `scale_factor`, `levels` and `patch_size`; the other OrbOptions belong to the detector.
///
/// Output: 32 bytes per feature, compared by Hamming distance.
///
/// Failure: Features whose patch and its blur (patch_size / 2 + 3 px of the level to each side) leave the
/// image are removed, as are all features of an image whose width or height is at most 2 patch_size.
///
/// Cost: O(pixels + features), in parallel over bands of rows and features.
///
/// Source: Rublee, Rabaud, Konolige and Bradski, ICCV 2011, section 4.
class OrbDescriptor : public Descriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit OrbDescriptor(const OrbOptions& options = {});

  void describe(const cv::Mat& grey, int threads, Workspace& workspace, Features& features) const override;
  std::string name() const override { return "orb"; }
  const OptionSet& options() const override { return options_; }

 private:
  OrbOptions options_;
  OrientedPatch patch_;
};

}  // namespace corrsel::core
