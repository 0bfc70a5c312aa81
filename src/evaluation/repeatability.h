#pragma once

#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Intersection divided by union of the ellipses of two frames, 0 to 1, to about 0.001. Each ellipse is first
/// scaled about its own centre by `scale`. 0 where a frame is not finite or has no area. O(1).
double ellipseOverlap(const AffineFrame& a, const AffineFrame& b, double scale = 1);

/// How many regions of two images of a plane show the same part of it.
struct Repeatability {
  std::size_t left = 0, right = 0;  ///< different regions whose centres are visible in both images
  std::size_t repeated = 0;         ///< pairs of corresponding regions; every region is in at most one pair

  /// repeated / min(left, right), 0 to 1; NaN where an image has no such region.
  double share() const;
};

/// Overlap error, 1 - intersection / union, up to which two regions correspond, and the radius to which they
/// are scaled for it, px, since large regions would otherwise overlap more easily.
inline constexpr double kMaxOverlapError = 0.4, kOverlapRadius = 30;

/// Counts regions that are detected in both images.
///
/// Algorithm: Features with one ellipse and different orientations are one region. Only regions are counted
/// whose centre lies in both images. The homography's derivative at the centre projects the ellipse of a left
/// region into the right image. Both ellipses are scaled about their own centres by the factor that gives the
/// projected one the radius kOverlapRadius (of the circle of its area), and correspond if their overlap error
/// is at most kMaxOverlapError. Pairs are chosen by decreasing overlap; equal overlaps are ordered by the
/// positions of the regions.
///
/// @param left, right  frames of the features, px
/// @param left_size, right_size  of the images, px
/// @param homography  from the left to the right image, px, up to scale and sign
///
/// Cost: O(N log N) for regions spread over the image.
///
/// Source: Mikolajczyk et al., "A comparison of affine region detectors", IJCV 2005, section 4.1.
Repeatability repeatability(const std::vector<AffineFrame>& left, const cv::Size& left_size,
                            const std::vector<AffineFrame>& right, const cv::Size& right_size,
                            const cv::Matx33d& homography);

/// Share of the features of `frames` beside which `others` has a feature whose centre is at most `distance`
/// px away and whose scale, the square root of the ellipse's area, differs by at most the share `scale` of
/// its own. NaN where `frames` is empty. O(N log N) for features spread over the image.
double agreement(const std::vector<AffineFrame>& frames, const std::vector<AffineFrame>& others,
                 double distance, double scale);

}  // namespace corrsel::core
