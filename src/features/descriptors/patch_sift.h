#pragma once

#include "features/descriptors/descriptor.h"
#include "features/detectors/sift.h"

namespace corrsel::core {

/// "sift": the SIFT descriptor (Lowe, IJCV 2004, section 6) of affine frames, of any detector. The region of
/// a frame is the square of 7.5 times its unit on each side of the centre, along its axes, so that the first
/// one points to direction 0: 4 x 4 cells, each 3 units wide, of 8 directions, with their gradients weighted
/// by a Gaussian of 6 units and spread over neighbouring cells and directions. The region is cut from a blur
/// of at most one unit. Lengths are 1, values at most 0.2 before the second normalisation.
///
/// 128 floats that are whole numbers from 0 to 255: 512 times the unit vector, rounded. With `root` they go
/// through toRootSift(). Of the options only `root` is used, the others are the detector's.
///
/// Removed: features whose frame is not finite or flat, whose centre is outside the image, whose region is
/// outside by more than half, or has one grey value only. Other regions that reach over the border see the
/// border's pixels repeated. Nothing is left of an image of one row or column. About 10 us per feature and 6
/// ns per pixel, up to 19 bytes per pixel.
class PatchSift : public Descriptor {
 public:
  explicit PatchSift(const SiftOptions& options = {});

  void describe(const cv::Mat& grey, int threads, Features& features) const override;
  std::string name() const override { return "sift"; }
  const OptionSet& options() const override { return options_; }

 private:
  SiftOptions options_;
};

}  // namespace corrsel::core
