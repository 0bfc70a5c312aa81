#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "features/parts/scale_level.h"

namespace corrsel::core {

/// The number of values of a SIFT descriptor.
inline constexpr int kSiftLength = 128;

/// The SIFT descriptor of the patch that a frame spans. All detectors share this implementation.
///
/// Algorithm: The region of a frame is the square of 7.5 units of the frame on each side of its centre, along
/// its axes, so the first axis points to direction 0. It is sampled every half unit from the most blurred
/// level whose blur is at most one unit. It has 4 x 4 cells of 3 units and 8 directions each. Gradients are
/// weighted by a Gaussian of 6 units and distributed linearly over neighbouring cells and directions. The
/// vector is normalised to length 1, clipped at 0.2 and normalised again.
///
/// Failure: Returns false, and leaves the descriptor undefined, where the frame is not finite or has no area,
/// where its centre is outside the image, where more than half of its region is outside, or where the region
/// has only one grey value. Other regions that reach over the border see the border's pixels repeated.
///
/// Cost: About 2 us.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004, section 6.
///
/// @param levels      at least one, in the order of sigma, each of at least 2 x 2 pixels
/// @param image       the size of the image that the levels show, px
/// @param descriptor  receives kSiftLength whole numbers from 0 to 255, i.e. 512 times the unit vector,
/// rounded
bool siftDescriptor(const std::vector<ScaleLevel>& levels, const AffineFrame& frame, const cv::Size& image,
                    float* descriptor);

/// The SIFT descriptor on a given level, wherever the region of the frame lies. What is beyond the border of
/// the image shows the border's pixels repeated. A region with only one grey value has the descriptor 0.
/// @pre the frame is finite
void siftDescriptor(const ScaleLevel& level, const AffineFrame& frame, float* descriptor);

/// The descriptors of many frames.
/// @param descriptors  receives one row per frame, CV_32F
/// @return a flag for each frame: not 0 where the frame has a descriptor
std::vector<char> siftDescriptors(const std::vector<ScaleLevel>& levels,
                                  const std::vector<AffineFrame>& frames, const cv::Size& image, int threads,
                                  cv::Mat& descriptors);

/// Whether a frame is finite, has an area, and has its centre inside the image.
bool isDescribable(const AffineFrame& frame, const cv::Size& image);

}  // namespace corrsel::core
