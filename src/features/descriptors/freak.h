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

/// "freak": 512 comparisons of mean grey levels in 43 receptive fields laid out as in the retina, coarse to
/// fine (Alahi, Ortiz and Vandergheynst, "FREAK: Fast Retina Keypoint", CVPR 2012); 64 bytes per feature,
/// test i in bit i % 8 of byte i / 8. The tests were chosen by the paper's procedure on the sample images
/// (scripts/train_freak.sh): descriptors do not compare with those of other implementations.
///
/// Against the paper: scale and orientation of the pattern are not rounded to a table's, and small fields
/// begin and end within pixels.
///
/// Keypoints get the angle that the pattern was turned by, frames of similarities follow it; affine frames
/// are kept as they are. Features whose pattern leaves the image are removed: with pattern_scale 22 those
/// closer to the border than 3.1 times their size. O(pixels + features).
class FreakDescriptor : public Descriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit FreakDescriptor(const FreakOptions& options = {});

  void describe(const cv::Mat& grey, int threads, Features& features) const override;
  std::string name() const override { return "freak"; }
  const OptionSet& options() const override { return options_; }

 private:
  FreakOptions options_;
};

}  // namespace corrsel::core
