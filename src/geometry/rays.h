#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Unit rays of many points, and their derivatives by the pixel: one column per number. Columns 0 to 2 are
/// the direction x, y, z, columns 3 to 8 the 3x2 Jacobian, row-major, 1/px.
struct Rays {
  static constexpr std::size_t kColumns = 9;

  std::array<std::vector<double>, kColumns> column;

  std::size_t size() const { return column[0].size(); }
  void resize(std::size_t n) {
    for (std::vector<double>& values : column) values.resize(n);
  }
  cv::Vec3d direction(std::size_t i) const { return {column[0][i], column[1][i], column[2][i]}; }
  cv::Matx<double, 3, 2> jacobian(std::size_t i) const {
    return {column[3][i], column[4][i], column[5][i], column[6][i], column[7][i], column[8][i]};
  }
  /// Size of a pixel, rad: the root mean square of the derivatives in both directions.
  double pixelAngle(std::size_t i) const;
};

/// Computes the rays of n points, bit for bit like unproject() of camera.h. The ray of a point that has none
/// is NaN.
/// @return number of points without a ray
std::size_t unproject(const Camera& camera, const float* x, const float* y, std::size_t n, Rays& rays);

/// The rays of both images; row i belongs to match i.
struct RayMatches {
  Rays left, right;

  std::size_t size() const { return left.size(); }
};

/// Computes the rays of all matches. @pre both cameras are given
/// @param exists  receives for each match whether both rays exist
/// @return number of matches with a missing ray
std::size_t unproject(const Correspondences& matches, RayMatches& rays, std::vector<std::uint8_t>& exists);

/// Copies the given rows, in that order.
void gatherRays(const RayMatches& from, const std::vector<std::uint32_t>& rows, RayMatches& to);

}  // namespace corrsel::core
