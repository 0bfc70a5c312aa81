#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <utility>
#include <vector>

#include "corrsel/correspondences.h"
#include "geometry/rays.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// The rays of matches in single precision, as the kernels read them: number k (kernels/residual.h) of the
/// ray of match i is left[k * size + i].
struct RayColumns {
  std::vector<float> left, right;
  std::size_t size = 0;

  /// Takes the given rows, in that order.
  void take(const RayMatches& rays, const std::vector<std::uint32_t>& rows);
  void take(const RayColumns& rays, const std::vector<std::uint32_t>& rows);

  /// Copies the given rows in double precision.
  void widen(const std::vector<std::uint32_t>& rows, RayMatches& to) const;
};

/// Matches shifted to their centroids (left and right separately) and divided by one scale common to both
/// images, so that float arithmetic keeps its precision and distances in the right image stay proportional to
/// pixels.
struct NormalizedMatches {
  std::vector<float> left_x, left_y, right_x, right_y;
  RayColumns rays;          ///< empty = no cameras
  double scale = 1.0;       ///< normalised = (pixel - centroid) * scale
  double rounding = 0.0;    ///< generous bound of rounding a point to single precision, normalised
  cv::Matx33d left, right;  ///< pixel to normalised coordinates, homogeneous

  std::size_t size() const { return left_x.size(); }

  /// The coordinates in the form that the kernels read; valid until the vectors change.
  MatchColumns columns() const {
    return {left_x.data(), left_y.data(),    right_x.data(),    right_y.data(),
            size(),        rays.left.data(), rays.right.data(), size()};
  }

  /// Converts a homography between normalised coordinates to one between pixels, with H(2,2) = 1 unless that
  /// is near 0.
  cv::Matx33d homographyToPixels(const cv::Matx33d& normalized) const;

  /// Converts a homography between pixels to one between normalised coordinates, with Frobenius norm 1.
  cv::Matx33d homographyFromPixels(const cv::Matx33d& pixels) const;

  /// Converts a fundamental matrix between normalised coordinates to one between pixels, with Frobenius
  /// norm 1.
  cv::Matx33d fundamentalToPixels(const cv::Matx33d& normalized) const;
};

/// Normalises the matches, in the given order of rows, into `result`, whose memory is reused. The scale is 1
/// if all points are equal. O(rows).
void normalizeMatches(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                      NormalizedMatches& result);

/// Takes matches for models of rays, in the given order of rows: their rays, and their coordinates as they
/// are, because the errors of these models are in px. O(rows).
/// @param rays  of all matches; those of the rows exist
void takeRays(const Correspondences& matches, const RayMatches& rays, const std::vector<std::uint32_t>& rows,
              NormalizedMatches& result);

/// Normalises all matches in the order of the input.
NormalizedMatches normalizeMatches(const Correspondences& matches);

/// Width and height of the box of the right points. @pre there is one
std::pair<double, double> rightExtent(const NormalizedMatches& matches);

/// Twice the signed area of the triangle of points a, b, c; 0 if they are on a line, apart from rounding.
inline double triangleArea(const std::vector<float>& x, const std::vector<float>& y, std::uint32_t a,
                           std::uint32_t b, std::uint32_t c, double rounding) {
  const double bx = static_cast<double>(x[b]) - x[a], by = static_cast<double>(y[b]) - y[a];
  const double cx = static_cast<double>(x[c]) - x[a], cy = static_cast<double>(y[c]) - y[a];
  const double area = bx * cy - by * cx;
  const double error = rounding * (std::abs(bx) + std::abs(by) + std::abs(cx) + std::abs(cy));
  return std::abs(area) <= error ? 0.0 : area;
}

}  // namespace corrsel::core
