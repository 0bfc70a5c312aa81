#pragma once

#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"

namespace corrsel::core {

/// Ground-truth error of every match, px:
/// - homography: distance between the right point and the projected left point (forward only); +Inf where the
///   third coordinate of the projection is not positive. The sign of the matrix is chosen so that the centre
///   of the left image has a positive one.
/// - fundamental matrix: distance of the right point from its epipolar line;
/// - disparity: distance of the right point from the point that the disparity predicts; NaN for a left point
///   without disparity;
/// - labels: 0 for an inlier, +Inf for an outlier;
/// - essential matrix: the tangent Sampson error (Terekhov and Larsson, ICCV 2023), which is the distance of
///   both points from their epipolar curves to first order;
/// - rotation: angle between the right ray and the turned left one, in pixels of the right point;
/// - no ground truth: NaN.
///
/// The error is also +Inf where a coordinate is not finite, or where a pixel has no ray. Throws
/// std::invalid_argument when labels and matches differ in number, and when matches without cameras are
/// compared with an essential matrix or a rotation. O(N).
std::vector<double> groundTruthErrors(const GroundTruth& truth, const Correspondences& matches);

}  // namespace corrsel::core
