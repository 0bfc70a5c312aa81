#pragma once

#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"

namespace corrsel::core {

/// Ground-truth error of every match in px: forward transfer distance (homography), distance of the right
/// point to its epipolar line (fundamental), distance to the point that the disparity predicts. Labels give 0
/// or +Inf. NaN where the truth is unknown (no ground truth, or a left point without disparity); +Inf where
/// the homography gives a third coordinate that is not positive, the sign of the matrix being chosen so that
/// the centre of the left image has a positive one, and where a coordinate is not finite. O(N). Throws
/// std::invalid_argument when labels and matches differ in number.
std::vector<double> groundTruthErrors(const GroundTruth& truth, const Correspondences& matches);

}  // namespace corrsel::core
