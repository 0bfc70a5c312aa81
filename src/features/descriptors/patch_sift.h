#pragma once

#include "features/descriptors/descriptor.h"
#include "features/detectors/sift.h"

namespace corrsel::core {

/// "sift" for the frames of any detector.
///
/// Idea: Histograms of gradient directions in the cells of a grid change little when the patch is shifted,
/// deformed or lit differently. Taken from the patch that an affine frame spans, they are invariant to its
/// shape as well.
///
/// Algorithm: The region of a frame is the square of 7.5 units of the frame on each side of its centre, along
/// its axes, so the first axis points to direction 0. It is sampled from a blur of at most one unit. It has 4
/// x 4 cells of 3 units and 8 directions each. Gradients are weighted by a Gaussian of 6 units and
/// distributed over neighbouring cells and directions. The vector is normalised to length 1, clipped at 0.2
/// and normalised again.
///
/// Input: 8-bit grey image and one frame per feature.
///
/// Options: only `root` of SiftOptions is used; the others belong to the detector.
///
/// Output: 128 floats that are whole numbers from 0 to 255, i.e. 512 times the unit vector, rounded. With
/// `root` they pass through toRootSift().
///
/// Failure: A feature is removed where its frame is not finite or has no area, where its centre is outside
/// the image, where more than half of its region is outside, or where the region has only one grey value.
/// Other regions that reach over the border see the border's pixels repeated. An image of one row or column
/// loses all features.
///
/// Cost: About 10 us per feature and 6 ns per pixel, up to 19 bytes per pixel.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004, section 6.
class PatchSift : public Descriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit PatchSift(const SiftOptions& options = {});

  void describe(const cv::Mat& grey, int threads, Features& features) const override;
  std::string name() const override { return "sift"; }
  const OptionSet& options() const override { return options_; }

 private:
  SiftOptions options_;
};

}  // namespace corrsel::core
