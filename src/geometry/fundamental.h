#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "geometry/normalization.h"

namespace corrsel::core {

/// Squared Sampson distance (Hartley and Zisserman, Eq. 11.9) in the unit of the coordinates squared. The
/// paper compares it with t_F: read as t_F squared.
double sampsonError(const cv::Matx33d& f, double left_x, double left_y, double right_x, double right_y);

/// Distance of the right point to the epipolar line F x, in the unit of the coordinates; NaN for the epipole
/// itself.
double epipolarLineDistance(const cv::Matx33d& f, double left_x, double left_y, double right_x,
                            double right_y);

/// The right epipole e', F^T e' = 0, of any length: the largest cross product of two columns of F; zero where
/// the rank is below 2.
cv::Vec3d leftNullVector(const cv::Matx33d& f);

/// Whether seven matches can fix a fundamental matrix: no two of them equal, not all points of one image on a
/// line.
bool isValidFundamentalSample(const NormalizedMatches& matches, const std::uint32_t* sample);

/// Fundamental matrices through seven matches (Hartley and Zisserman, 11.1.2): one or three, written to f.
/// @return how many; 0 where the sample is degenerate. Models for which the seven points would have to lie
/// partly behind a camera (oriented epipolar constraint, Chum et al. 2004) are left out.
int fundamentalFromSeven(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d f[3]);

/// One Gauss-Newton step on the sum of squared Sampson distances of the matches whose distance under f is at
/// most squared_threshold, normalised: the gradients are those of f, the step keeps rank 2, the result has
/// Frobenius norm
/// 1. @pre |f| = 1, rank 2. @return false, f unchanged, where those matches do not fix a fundamental matrix.
/// O(N).
bool refineFundamental(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& f);

}  // namespace corrsel::core
