#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/geometry/normalization.h"

namespace corrsel::core {

/// Squared forward transfer error |x' - H x|^2, the paper's Eq. 3, in the unit of the coordinates squared;
/// +Inf where the third coordinate of H x is not positive (point behind the camera).
double homographyError(const cv::Matx33d& h, double left_x, double left_y, double right_x, double right_y);

/// The same for matches [begin, end), written to out[0 .. end - begin).
void homographyErrors(const cv::Matx33d& h, const NormalizedMatches& matches, std::size_t begin,
                      std::size_t end, float* out);

/// Whether four matches can come from one camera pair looking at a plane: no three points on a line in either
/// image, and the orientations of all four triplets kept or all turned over (OpenCV's and USAC's sample
/// test).
bool isValidHomographySample(const NormalizedMatches& matches, const std::uint32_t* sample);

/// Homography through four matches, scaled so that all four have a positive third coordinate. Closed form
/// through the projective basis (Hartley and Zisserman, ch. 4). @return false where the sample is degenerate.
bool homographyFromFour(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d& h);

/// Least squares on the given matches: direct linear transform, then Gauss-Newton on the forward transfer
/// error.
/// @return false with fewer than four matches or where the system is singular. O(rows).
bool fitHomography(const NormalizedMatches& matches, const std::vector<std::uint32_t>& rows, cv::Matx33d& h);

}  // namespace corrsel::core
