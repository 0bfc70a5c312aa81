#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "corrsel/workspace.h"

namespace corrsel::core {

struct TiltedView {
  cv::Mat pixels;        ///< CV_16S, kGreyUnit times the grey level
  cv::Matx23d to_image;  ///< from its pixels to those of the image
};

/// Simulates views of an image from tilted cameras.
///
/// Algorithm: The image is rotated with bilinear interpolation, blurred vertically by 0.8 sqrt(tilt^2 - 1) px
/// against aliasing, and compressed vertically by the tilt. A rotated row is computed where it shows the
/// image, and its first and last pixel are repeated elsewhere. Everything is computed in whole numbers, row
/// by row.
///
/// Cost: 4 bytes per pixel of the image, and about 2 ns for every pixel of the rotated image with AVX2.
///
/// Source: Yu and Morel, "ASIFT: An Algorithm for Fully Affine Invariant Comparison", IPOL 2011.
class TiltedViews {
 public:
  /// @param grey  CV_8U, not empty
  explicit TiltedViews(const cv::Mat& grey);

  /// May be called by several threads at the same time, each with its own workspace.
  /// @param tilt  at least 1.2
  /// @param turn  of the image before the compression, radians, counterclockwise as seen in the image
  /// @return its pixels are valid until the next view in this workspace
  TiltedView view(double tilt, double turn, Workspace& workspace) const;

 private:
  cv::Size size_;
  std::vector<std::uint32_t> quads_;
};

}  // namespace corrsel::core
