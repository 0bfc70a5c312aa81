#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace corrsel::core {

/// The quadratic through samples at and around a point of a scale space, and its extremum (Brown and Lowe,
/// "Invariant Features from Interest Point Groups", BMVC 2002).
struct QuadraticFit {
  double value;        ///< of the sample at the point
  cv::Vec3d gradient;  ///< along x, y and level
  double xx, xy, yy;   ///< second derivatives
  cv::Vec3d offset;    ///< of the extremum from the point: x, y, level
  bool solved;         ///< false where the quadratic has no single extremum; `offset` is then meaningless

  /// The largest absolute component of the offset.
  double reach() const { return std::max({std::abs(offset[0]), std::abs(offset[1]), std::abs(offset[2])}); }

  /// The value of the quadratic at its extremum.
  double extremum() const { return value + gradient.dot(offset) / 2; }

  /// Trace and determinant of the Hessian over x and y, whose ratio separates edges from blobs (Lowe, IJCV
  /// 2004, section 4.1).
  double trace() const { return xx + yy; }
  double determinant() const { return xx * yy - xy * xy; }
};

/// @param at  at(level, y, x) is the sample at this offset, each from -1 to 1. Differences are computed in
/// the type that it returns.
template <class At>
QuadraticFit fitQuadratic(const At& at) {
  QuadraticFit fit;
  fit.value = at(0, 0, 0);
  fit.gradient = {(at(0, 0, 1) - at(0, 0, -1)) / 2, (at(0, 1, 0) - at(0, -1, 0)) / 2,
                  (at(1, 0, 0) - at(-1, 0, 0)) / 2};
  fit.xx = at(0, 0, 1) + at(0, 0, -1) - 2 * fit.value;
  fit.yy = at(0, 1, 0) + at(0, -1, 0) - 2 * fit.value;
  const double ll = at(1, 0, 0) + at(-1, 0, 0) - 2 * fit.value;
  fit.xy = (at(0, 1, 1) - at(0, 1, -1) - at(0, -1, 1) + at(0, -1, -1)) / 4;
  const double xl = (at(1, 0, 1) - at(1, 0, -1) - at(-1, 0, 1) + at(-1, 0, -1)) / 4;
  const double yl = (at(1, 1, 0) - at(1, -1, 0) - at(-1, 1, 0) + at(-1, -1, 0)) / 4;
  const cv::Matx33d hessian(fit.xx, fit.xy, xl, fit.xy, fit.yy, yl, xl, yl, ll);
  fit.offset = -(hessian.inv(cv::DECOMP_LU, &fit.solved) * fit.gradient);
  return fit;
}

}  // namespace corrsel::core
