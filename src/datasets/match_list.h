#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Putative matches from a file, and what the file says about their correctness.
struct MatchList {
  Correspondences matches;  ///< without sizes of images
  bool labelled = false;
  std::vector<std::uint32_t> labels;  ///< where labelled, per match: 0 = outlier, k = member of structure k
};

/// Reads matches from a text file of numbers separated by commas. The first line names the columns, in any
/// order; a leading '#' is skipped, so that the output of numpy.savetxt can be read.
/// - `x_left`, `y_left`, `x_right`, `y_right`: px, the centre of the first pixel is (0, 0);
/// - `distance`: optional, descriptor distance to the nearest neighbour, from 0;
/// - `second_distance`: optional, that to the second-nearest neighbour, from 0; nan = there is none;
/// - `ratio`: optional, in the place of `second_distance`: the nearest distance divided by the second.
///   Without `distance`, the ratio becomes the distance and 1 the second one;
/// - `match_probability`: optional, the matcher's probability that the match is right, 0 to 1; nan = unknown;
/// - `size_left`, `angle_left`, `size_right`, `angle_right`: optional, together: diameter [px] and angle
///   [degrees] of the keypoints as in cv::KeyPoint, from which similarity frames are made;
/// - `index_left`, `index_right`: optional, together: numbers of the features in their images, from 0;
/// - `label`: optional, 0 = outlier, 1 = inlier, or k = member of structure k.
///
/// Throws DatasetError that names the file, the line, the column and the value. O(matches).
MatchList readMatchList(const std::string& path);

}  // namespace corrsel::core
