#include "geometry/homography.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "geometry/residual.h"

namespace corrsel::core {
namespace {

/// The matrix that maps the projective basis e1, e2, e3, e1+e2+e3 to four points.
bool basis(const std::vector<float>& x, const std::vector<float>& y, const std::uint32_t* s,
           cv::Matx33d& result) {
  const double x0 = x[s[0]], y0 = y[s[0]], x1 = x[s[1]], y1 = y[s[1]], x2 = x[s[2]], y2 = y[s[2]];
  const double dx = x[s[3]], dy = y[s[3]];
  // By Cramer's rule, weight k is the area of the triangle with point 4 in the place of point k.
  const double w0 = (x1 - dx) * (y2 - dy) - (y1 - dy) * (x2 - dx);
  const double w1 = (x2 - dx) * (y0 - dy) - (y2 - dy) * (x0 - dx);
  const double w2 = (x0 - dx) * (y1 - dy) - (y0 - dy) * (x1 - dx);
  if (w0 == 0 || w1 == 0 || w2 == 0) return false;
  result = cv::Matx33d(w0 * x0, w1 * x1, w2 * x2, w0 * y0, w1 * y1, w2 * y2, w0, w1, w2);
  return true;
}

/// Twice the signed areas of the triangles of points 0 1 2, 0 1 3, 0 2 3 and 1 2 3. @return the sum of the
/// sides' extents, which bounds what a unit of rounding may change
inline double fourTriangles(const std::vector<float>& x, const std::vector<float>& y, const std::uint32_t* s,
                            double (&areas)[4]) {
  double dx[3], dy[3], extent = 0;
  for (int k = 0; k < 3; ++k) {
    dx[k] = static_cast<double>(x[s[k + 1]]) - x[s[0]];
    dy[k] = static_cast<double>(y[s[k + 1]]) - y[s[0]];
    extent += std::abs(dx[k]) + std::abs(dy[k]);
  }
  areas[0] = dx[0] * dy[1] - dy[0] * dx[1];
  areas[1] = dx[0] * dy[2] - dy[0] * dx[2];
  areas[2] = dx[1] * dy[2] - dy[1] * dx[2];
  areas[3] = (dx[1] - dx[0]) * (dy[2] - dy[0]) - (dy[1] - dy[0]) * (dx[2] - dx[0]);
  return extent;
}

}  // namespace

cv::Matx33d adjugateOf(const cv::Matx33d& m) {
  return {m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1), m(0, 2) * m(2, 1) - m(0, 1) * m(2, 2),
          m(0, 1) * m(1, 2) - m(0, 2) * m(1, 1), m(1, 2) * m(2, 0) - m(1, 0) * m(2, 2),
          m(0, 0) * m(2, 2) - m(0, 2) * m(2, 0), m(0, 2) * m(1, 0) - m(0, 0) * m(1, 2),
          m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0), m(0, 1) * m(2, 0) - m(0, 0) * m(2, 1),
          m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0)};
}

bool isValidHomographySample(const NormalizedMatches& m, const std::uint32_t* s) {
  double left[4], right[4];
  const double left_error = m.rounding * fourTriangles(m.left_x, m.left_y, s, left);
  const double right_error = m.rounding * fourTriangles(m.right_x, m.right_y, s, right);
  bool all_kept = true, all_turned = true, any_flat = false;
  for (int k = 0; k < 4; ++k) {
    any_flat |= std::abs(left[k]) <= left_error || std::abs(right[k]) <= right_error;
    const bool kept = left[k] * right[k] > 0;
    all_kept &= kept;
    all_turned &= !kept;
  }
  return !any_flat && (all_kept || all_turned);
}

bool homographyFromFour(const NormalizedMatches& m, const std::uint32_t* s, cv::Matx33d& h) {
  cv::Matx33d left, right;
  if (!basis(m.left_x, m.left_y, s, left) || !basis(m.right_x, m.right_y, s, right)) return false;
  // The adjugate replaces the inverse, because the scale of a homography is free.
  h = right * adjugateOf(left);
  const double norm = cv::norm(h);
  if (!(norm > 0) || !std::isfinite(norm)) return false;
  h = h * (1.0 / norm);
  if (thirdCoordinate(h, m.left_x[s[0]], m.left_y[s[0]]) < 0) h = h * -1.0;
  for (int k = 0; k < 4; ++k) {
    if (!(thirdCoordinate(h, m.left_x[s[k]], m.left_y[s[k]]) > 0)) return false;
  }
  return true;
}

bool refineHomography(const NormalizedMatches& matches, Residual residual, float squared_threshold,
                      cv::Matx33d& h) {
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  double sums[kHomographySums];
  kernels().residuals.normal[static_cast<std::size_t>(residual)](residualModel(residual, h),
                                                                 matches.columns(), squared_threshold, sums);
  // The derivative of (u, v) by the rows of H: (p, 0, -u p) and (0, p, -v p).
  Matrix9 normal = Matrix9::Zero();
  Vector9 gradient;
  int k = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++k) {
      normal(i, j) = normal(j, i) = normal(3 + i, 3 + j) = normal(3 + j, 3 + i) = sums[k];
      normal(i, 6 + j) = normal(j, 6 + i) = normal(6 + j, i) = normal(6 + i, j) = -sums[6 + k];
      normal(3 + i, 6 + j) = normal(3 + j, 6 + i) = normal(6 + j, 3 + i) = normal(6 + i, 3 + j) =
          -sums[12 + k];
      normal(6 + i, 6 + j) = normal(6 + j, 6 + i) = sums[18 + k];
    }
    gradient(i) = sums[24 + i];
    gradient(3 + i) = sums[27 + i];
    gradient(6 + i) = -sums[30 + i];
  }
  const double trace = normal.trace();
  const Vector9 current = Eigen::Map<const Vector9>(h.val);
  // h and its multiples are the same homography; the added rank fixes the scale.
  normal += current * current.transpose() * (trace / current.squaredNorm());
  const Eigen::LDLT<Matrix9> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-9 * trace)) return false;
  const Vector9 refined = current + solver.solve(gradient);
  const double norm = refined.norm();
  if (!std::isfinite(norm) || !(norm > 0)) return false;
  for (int i = 0; i < 9; ++i) h.val[i] = refined(i) / norm;
  return true;
}

}  // namespace corrsel::core
