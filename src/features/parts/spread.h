#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// Which points to keep so that they are strong and cover the image: the image is cut into about `most` / 4
/// square cells, and the strongest of every cell go first, then the second strongest, and so on; within a
/// round, stronger points first.
/// @param points  strongest first, px
/// @param size    of the image, px
/// @return min(most, points) ranks in ascending order, that is strongest first. O(n log n).
std::vector<std::size_t> spreadOverImage(const std::vector<cv::Point2f>& points, const cv::Size& size,
                                         std::size_t most);

}  // namespace corrsel::core
