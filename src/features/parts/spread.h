#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// Selects strong points that cover the image.
///
/// Algorithm: The image is divided into about `max_points` / 4 square cells. The strongest points of all
/// cells are taken first, then the second strongest, and so on. Where a round exceeds `max_points`, its
/// strongest points are taken. Points beyond the border belong to the nearest cell.
///
/// Cost: O(n log n).
///
/// @param points  sorted, strongest first, px
/// @param size    of the image, px
/// @return min(max_points, points) indices of points in ascending order, i.e. strongest first
std::vector<std::size_t> spreadOverImage(const std::vector<cv::Point2f>& points, const cv::Size& size,
                                         std::size_t max_points);

}  // namespace corrsel::core
