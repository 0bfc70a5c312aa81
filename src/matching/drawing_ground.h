#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// The image with three channels, BGR. An image that has them is not copied.
cv::Mat toColour(const cv::Mat& image);

/// Whether all coordinates of a match are near enough to be drawn.
bool drawable(const Correspondences& matches, std::size_t row);

/// Returns the image, or a black one of `size` instead of an empty one. Where the size is unknown, the black
/// image holds all points that can be drawn.
cv::Mat imageOrGround(const cv::Mat& image, cv::Size size, const std::vector<float>& x,
                      const std::vector<float>& y);

/// The colour of a group whose motion is known (BGR): that of moving matches, or one of four others in turn.
cv::Scalar colourOf(std::int32_t group, GroupMotion motion);

}  // namespace corrsel::core
