#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/geometry/normalization.h"

namespace corrsel::core {

/// Squared Sampson distance (Hartley and Zisserman, Eq. 11.9) in the unit of the coordinates squared. The
/// paper compares it with t_F: read as t_F squared.
double sampsonError(const cv::Matx33d& f, double left_x, double left_y, double right_x, double right_y);

/// The same for matches [begin, end), written to out[0 .. end - begin).
void sampsonErrors(const cv::Matx33d& f, const NormalizedMatches& matches, std::size_t begin, std::size_t end,
                   float* out);

/// Distance of the right point to the epipolar line F x, in the unit of the coordinates; NaN for the epipole
/// itself.
double epipolarLineDistance(const cv::Matx33d& f, double left_x, double left_y, double right_x,
                            double right_y);

/// Whether seven matches can fix a fundamental matrix: no two of them equal, not all points of one image on a
/// line.
bool isValidFundamentalSample(const NormalizedMatches& matches, const std::uint32_t* sample);

/// Fundamental matrices through seven matches (Hartley and Zisserman, 11.1.2): one or three, written to f.
/// @return how many; 0 where the sample is degenerate. Models for which the seven points would have to lie
/// partly behind a camera (oriented epipolar constraint, Chum et al. 2004) are left out.
int fundamentalFromSeven(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d f[3]);

/// Least squares on the given matches: eight-point algorithm weighted towards the Sampson distance, three
/// rounds, rank 2 enforced. @return false with fewer than eight matches or where the system is singular.
/// O(rows).
bool fitFundamental(const NormalizedMatches& matches, const std::vector<std::uint32_t>& rows, cv::Matx33d& f);

}  // namespace corrsel::core
