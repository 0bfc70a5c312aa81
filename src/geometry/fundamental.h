#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "geometry/normalization.h"

namespace corrsel::core {

/// Squared Sampson distance (Hartley and Zisserman, Eq. 11.9) in the unit of the coordinates squared. The
/// paper compares it with t_F, which is taken to mean t_F squared.
double sampsonError(const cv::Matx33d& f, double left_x, double left_y, double right_x, double right_y);

/// Distance of the right point to the epipolar line F x, in the unit of the coordinates; NaN for the epipole
/// itself.
double epipolarLineDistance(const cv::Matx33d& f, double left_x, double left_y, double right_x,
                            double right_y);

/// The right epipole e', for which F^T e' = 0, of any length. It is computed as the largest cross product of
/// two columns of F, and is zero if the rank is below 2.
cv::Vec3d leftNullVector(const cv::Matx33d& f);

/// Returns whether seven matches can determine a fundamental matrix: no two of them are equal, and in neither
/// image are all points on a line.
bool isValidFundamentalSample(const NormalizedMatches& matches, const std::uint32_t* sample);

/// Writes the one or three fundamental matrices through seven matches to f (Hartley and Zisserman, 11.1.2).
/// Leaves out those for which some of the seven points would lie behind a camera (oriented epipolar
/// constraint, Chum et al. 2004).
///
/// Seven matches that agree with one homography to within rounding, as in identical images, leave the family
/// [e']_x H undetermined. All its members fit equally well, and one of them is returned.
/// @return number of matrices; 0 if the sample is degenerate otherwise
int fundamentalFromSeven(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d f[3]);

/// Takes one Gauss-Newton step on the sum of squared Sampson distances of the matches whose squared distance
/// under f is at most squared_threshold, in normalised coordinates. The gradients are those of f. The step
/// keeps rank 2, and the result has Frobenius norm 1. O(N).
/// @pre |f| = 1, rank 2
/// @return false, with f unchanged, if those matches do not determine a fundamental matrix
bool refineFundamental(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& f);

}  // namespace corrsel::core
