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
/// Algorithm: Every frame is described as in siftDescriptor(), on the levels of the detector's scale space
/// or, where it has none, on levels of its own that are a factor of sqrt(2) apart.
///
/// Input: 8-bit grey image and one frame per feature.
///
/// Options: Only `root` of SiftOptions is used; the others belong to the detector.
///
/// Output: 128 floats that are whole numbers from 0 to 255. With `root` they pass through toRootSift().
///
/// Failure: A feature is removed where siftDescriptor() fails. An image of one row or column loses all
/// features.
///
/// Cost: About 2 us per feature. Levels of its own cost a few ns and 9 bytes per pixel; the memory is kept
/// for the next image.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004, section 6.
class PatchSift : public Descriptor {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit PatchSift(const SiftOptions& options = {});

  void describe(const cv::Mat& grey, int threads, Workspace& workspace, Features& features) const override;
  void describeOn(const std::vector<ScaleLevel>& levels, const cv::Mat& grey, int threads,
                  Workspace& workspace, Features& features) const override;
  std::string name() const override { return "sift"; }
  const OptionSet& options() const override { return options_; }

 private:
  SiftOptions options_;
};

}  // namespace corrsel::core
