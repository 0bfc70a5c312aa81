#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// Which points to keep so that no two are closer than `min_distance` px: a point is dropped where an earlier
/// one that is kept is closer. O(points).
/// @param size  of the image, px
std::vector<char> keepDistant(const std::vector<cv::Point2f>& points, const cv::Size& size,
                              double min_distance);

/// Chooses new points where there are the fewest.
///
/// Algorithm: The image is divided into about `max_points` / 4 square cells. A candidate has the rank of the
/// number of points and stronger candidates in its cell. Candidates are taken by rank, then by strength.
///
/// Cost: O(candidates log candidates + points).
///
/// @param candidates  strongest first, px
/// @param points      that are there already, px
/// @param max_points  with those that are there
/// @return indices of candidates, at most max_points - points
std::vector<std::size_t> chooseNew(const std::vector<cv::Point2f>& candidates,
                                   const std::vector<cv::Point2f>& points, const cv::Size& size,
                                   std::size_t max_points);

}  // namespace corrsel::core
