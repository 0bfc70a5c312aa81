#pragma once

#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"

namespace corrsel::core {

/// Computes the ground-truth error of every match, px.
///
///  - Homography: forward transfer distance; +Inf if the third coordinate is not positive. The sign of the
///  matrix is
///    chosen so that the centre of the left image has a positive one.
///  - Fundamental matrix: distance of the right point to its epipolar line.
///  - Disparity: distance to the point that the disparity predicts; NaN for a left point without disparity.
///  - Labels: 0 for a member of a structure, +Inf for an outlier.
///
/// All errors are NaN without ground truth. An error is +Inf if a coordinate is not finite. O(N).
/// Throws std::invalid_argument if labels and matches differ in number.
std::vector<double> groundTruthErrors(const GroundTruth& truth, const Correspondences& matches);

}  // namespace corrsel::core
