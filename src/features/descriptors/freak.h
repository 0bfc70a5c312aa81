#pragma once

#include <string>

#include "features/descriptors/descriptor.h"

namespace corrsel::core {

struct FreakOptions : OptionSet {
  double pattern_scale = 22.0;         ///< of the pattern around a keypoint of 7 px, px
  bool orientation_normalized = true;  ///< turn the pattern with the image; otherwise it stays upright
  bool scale_normalized = true;        ///< let the pattern grow with the keypoint

  void visit(OptionVisitor& visitor) const override;
};

/// "freak" for the keypoints of any detector.
///
/// Idea: Receptive fields laid out as in the human retina, dense in the centre and sparse outside, are
/// compared in pairs; the large fields are compared first, so a matcher may stop early.
///
/// Algorithm: 512 comparisons of mean grey levels in 43 receptive fields. The direction of the pattern is the
/// mean gradient over 45 symmetric pairs. The comparisons were chosen on the sample images by the paper's
/// procedure (scripts/maintenance/train_freak.sh), so descriptors cannot be compared with those of other
/// implementations. In contrast to the paper, scale and direction of the pattern are not rounded to a table's
/// values, and small fields may begin and end within pixels.
///
/// Input: 8-bit grey image and keypoints with sizes.
///
/// Options: FreakOptions.
///
/// Output: 64 bytes per feature, comparison i in bit i % 8 of byte i / 8. A keypoint's angle becomes the
/// direction of its pattern. Frames that are similarities are rotated with it; affine frames stay as they
/// are.
///
/// Failure: Features whose pattern leaves the image are removed. With pattern_scale 22 these are the features
/// closer to the border than 3.1 times their size.
///
/// Cost: O(pixels + features).
///
/// Source: Alahi, Ortiz and Vandergheynst, "FREAK: Fast Retina Keypoint", CVPR 2012.
class FreakDescriptor : public Descriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit FreakDescriptor(const FreakOptions& options = {});

  void describe(const cv::Mat& grey, int threads, Workspace& workspace, Features& features) const override;
  std::string name() const override { return "freak"; }
  const OptionSet& options() const override { return options_; }

 private:
  FreakOptions options_;
};

}  // namespace corrsel::core
