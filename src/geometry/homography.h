#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "geometry/normalization.h"

namespace corrsel::core {

/// The adjugate: det(m) times the inverse of m. It exists for every matrix.
cv::Matx33d adjugateOf(const cv::Matx33d& m);

/// Third homogeneous coordinate of H (x, y, 1).
inline double thirdCoordinate(const cv::Matx33d& h, double x, double y) {
  return h(2, 0) * x + h(2, 1) * y + h(2, 2);
}

/// H or -H, whichever gives the point (x, y) a positive third coordinate: a homography is given up to scale,
/// and some files have a negative one (VGG's leuven 1-5).
inline cv::Matx33d inFront(const cv::Matx33d& h, double x, double y) {
  return thirdCoordinate(h, x, y) < 0 ? h * -1.0 : h;
}

/// Squared forward transfer error |x' - H x|^2, the paper's Eq. 3, in the unit of the coordinates squared;
/// +Inf if the third coordinate of H x is not positive (point behind the camera).
inline double homographyError(const cv::Matx33d& h, double left_x, double left_y, double right_x,
                              double right_y) {
  const double w = thirdCoordinate(h, left_x, left_y);
  const double inverse = 1.0 / w;
  const double dx = (h(0, 0) * left_x + h(0, 1) * left_y + h(0, 2)) * inverse - right_x;
  const double dy = (h(1, 0) * left_x + h(1, 1) * left_y + h(1, 2)) * inverse - right_y;
  return w > 0 ? dx * dx + dy * dy : std::numeric_limits<double>::infinity();
}

/// Returns whether four matches can come from a pair of cameras that look at a plane: no three points are on
/// a line in either image, and the orientations of the four triplets are all kept or all reversed (the sample
/// test of OpenCV and USAC).
bool isValidHomographySample(const NormalizedMatches& matches, const std::uint32_t* sample);

/// Computes the homography through four matches, scaled so that all four have a positive third coordinate, in
/// closed form through the projective basis (Hartley and Zisserman, ch. 4).
/// @return false if the sample is degenerate
bool homographyFromFour(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d& h);

/// Takes one Gauss-Newton step on the sum of squared transfer errors of the matches whose squared error under
/// h (by `residual`) is at most squared_threshold, in normalised coordinates. The result has Frobenius
/// norm 1. O(N).
/// @return false, with h unchanged, if those matches do not determine a homography
bool refineHomography(const NormalizedMatches& matches, Residual residual, float squared_threshold,
                      cv::Matx33d& h);

}  // namespace corrsel::core
