#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// How an image states what it excludes.
struct MaskOptions {
  /// Labels of a label image, as a segmentation network makes it, that are excluded. Empty: the image is a
  /// mask, which excludes where it is zero.
  std::vector<int> classes;
  /// What is excluded grows by so many pixels of the mask in each direction of both axes; at least 0.
  int dilation = 0;
};

/// Makes a mask of 8 bits with one channel, which is 0 where the image excludes and 255 elsewhere, from a
/// mask or a label image of 8 or 16 bits with one channel. O(pixels (classes + dilation)). Throws
/// std::invalid_argument that names the type of another image.
cv::Mat toMask(const cv::Mat& image, const MaskOptions& options = {});

/// The mask for an image of this size: itself where the sizes are equal, and scaled (nearest pixel) where the
/// ratios of their sides are, up to a pixel of the mask. A size of 0x0 is not known, and fits every mask.
/// Throws std::invalid_argument that names both sizes otherwise.
cv::Mat fittedMask(const cv::Mat& mask, const cv::Size& image);

/// The rows of the matches neither of whose points lies on a zero of its mask, in ascending order. The pixel
/// nearest to a point counts; a point that is not finite lies on none. O(matches).
/// @param left_mask   8-bit, one channel, in pixels of the left image; empty = none
/// @param right_mask  the same for the right image
std::vector<std::uint32_t> unmaskedRows(const Correspondences& matches, const cv::Mat& left_mask,
                                        const cv::Mat& right_mask);

}  // namespace corrsel::core
