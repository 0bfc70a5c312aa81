#include "corrsel/geometry/homography.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "corrsel/kernels/kernels.h"

namespace corrsel::core {
namespace {

/// The matrix that maps the projective basis e1, e2, e3, e1+e2+e3 to four points.
bool basis(const std::vector<float>& x, const std::vector<float>& y, const std::uint32_t* s,
           cv::Matx33d& result) {
  // Cramer's rule: weight k is the area of the triangle with point 4 in the place of point k.
  const double w0 = triangleArea(x, y, s[3], s[1], s[2], 0.0);
  const double w1 = triangleArea(x, y, s[0], s[3], s[2], 0.0);
  const double w2 = triangleArea(x, y, s[0], s[1], s[3], 0.0);
  if (w0 == 0 || w1 == 0 || w2 == 0) return false;
  result = cv::Matx33d(w0 * x[s[0]], w1 * x[s[1]], w2 * x[s[2]], w0 * y[s[0]], w1 * y[s[1]], w2 * y[s[2]], w0,
                       w1, w2);
  return true;
}

double thirdCoordinate(const cv::Matx33d& h, double x, double y) {
  return h(2, 0) * x + h(2, 1) * y + h(2, 2);
}

bool directLinearTransform(const NormalizedMatches& m, const std::vector<std::uint32_t>& rows,
                           cv::Matx33d& h) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const std::uint32_t i : rows) {
    const double x = m.left_x[i], y = m.left_y[i], u = m.right_x[i], v = m.right_y[i];
    Eigen::Matrix<double, 9, 1> a, b;
    a << x, y, 1, 0, 0, 0, -u * x, -u * y, -u;
    b << 0, 0, 0, x, y, 1, -v * x, -v * y, -v;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(a);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(b);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()(1) > 1e-12 * solver.eigenvalues()(8)))
    return false;
  const Eigen::Matrix<double, 9, 1> solution = solver.eigenvectors().col(0);
  for (int k = 0; k < 9; ++k) h.val[k] = solution(k);
  // The sign for which most points lie before the camera.
  std::size_t positive = 0;
  for (const std::uint32_t i : rows) positive += thirdCoordinate(h, m.left_x[i], m.left_y[i]) > 0 ? 1 : 0;
  if (2 * positive < rows.size()) h = h * -1.0;
  return true;
}

/// One Gauss-Newton step on the sum of squared transfer errors, over the eight directions orthogonal to h
/// itself.
bool gaussNewtonStep(const NormalizedMatches& m, const std::vector<std::uint32_t>& rows, cv::Matx33d& h) {
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  Matrix9 normal = Matrix9::Zero();
  Vector9 gradient = Vector9::Zero();
  for (const std::uint32_t i : rows) {
    const double x = m.left_x[i], y = m.left_y[i];
    const double w = thirdCoordinate(h, x, y);
    if (!(w > 0)) continue;
    const double u = (h(0, 0) * x + h(0, 1) * y + h(0, 2)) / w, v = (h(1, 0) * x + h(1, 1) * y + h(1, 2)) / w;
    Vector9 a, b;
    a << x, y, 1, 0, 0, 0, -u * x, -u * y, -u;
    b << 0, 0, 0, x, y, 1, -v * x, -v * y, -v;
    a /= w;
    b /= w;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(a);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(b);
    gradient += a * (m.right_x[i] - u) + b * (m.right_y[i] - v);
  }
  normal = normal.selfadjointView<Eigen::Lower>();
  const Vector9 current = Eigen::Map<const Vector9>(h.val);
  // h and its multiples are one homography: the added rank pins the scale.
  normal += current * current.transpose() * (normal.trace() / current.squaredNorm());
  const Eigen::LDLT<Matrix9> solver(normal);
  if (solver.info() != Eigen::Success) return false;
  const Vector9 step = solver.solve(gradient);
  if (!step.allFinite()) return false;
  for (int k = 0; k < 9; ++k) h.val[k] += step(k);
  return true;
}

}  // namespace

double homographyError(const cv::Matx33d& h, double left_x, double left_y, double right_x, double right_y) {
  const double w = thirdCoordinate(h, left_x, left_y);
  if (!(w > 0)) return std::numeric_limits<double>::infinity();
  const double dx = (h(0, 0) * left_x + h(0, 1) * left_y + h(0, 2)) / w - right_x;
  const double dy = (h(1, 0) * left_x + h(1, 1) * left_y + h(1, 2)) / w - right_y;
  return dx * dx + dy * dy;
}

void homographyErrors(const cv::Matx33d& h, const NormalizedMatches& m, std::size_t begin, std::size_t end,
                      float* out) {
  ResidualModel model{};
  for (int i = 0; i < 9; ++i) model.forward[i] = static_cast<float>(h.val[i]);
  kernels().errors[static_cast<std::size_t>(Residual::kTransfer)](model, m.columns(), begin, end, out);
}

bool isValidHomographySample(const NormalizedMatches& m, const std::uint32_t* s) {
  constexpr int kTriplets[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  int kept = 0;
  for (const auto& t : kTriplets) {
    const double left = triangleArea(m.left_x, m.left_y, s[t[0]], s[t[1]], s[t[2]], m.rounding);
    const double right = triangleArea(m.right_x, m.right_y, s[t[0]], s[t[1]], s[t[2]], m.rounding);
    if (left == 0 || right == 0) return false;
    kept += (left > 0) == (right > 0) ? 1 : 0;
  }
  return kept == 0 || kept == 4;
}

bool homographyFromFour(const NormalizedMatches& m, const std::uint32_t* s, cv::Matx33d& h) {
  cv::Matx33d left, right;
  if (!basis(m.left_x, m.left_y, s, left) || !basis(m.right_x, m.right_y, s, right)) return false;
  // Adjugate instead of inverse: the scale of a homography is free.
  const cv::Matx33d& a = left;
  const cv::Matx33d adjugate(a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1), a(0, 2) * a(2, 1) - a(0, 1) * a(2, 2),
                             a(0, 1) * a(1, 2) - a(0, 2) * a(1, 1), a(1, 2) * a(2, 0) - a(1, 0) * a(2, 2),
                             a(0, 0) * a(2, 2) - a(0, 2) * a(2, 0), a(0, 2) * a(1, 0) - a(0, 0) * a(1, 2),
                             a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0), a(0, 1) * a(2, 0) - a(0, 0) * a(2, 1),
                             a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0));
  h = right * adjugate;
  const double norm = cv::norm(h);
  if (!(norm > 0) || !std::isfinite(norm)) return false;
  h = h * (1.0 / norm);
  if (thirdCoordinate(h, m.left_x[s[0]], m.left_y[s[0]]) < 0) h = h * -1.0;
  for (int k = 0; k < 4; ++k) {
    if (!(thirdCoordinate(h, m.left_x[s[k]], m.left_y[s[k]]) > 0)) return false;
  }
  return true;
}

bool fitHomography(const NormalizedMatches& matches, const std::vector<std::uint32_t>& rows, cv::Matx33d& h) {
  if (rows.size() < 4) return false;
  cv::Matx33d fitted;
  if (!directLinearTransform(matches, rows, fitted)) return false;
  for (int step = 0; step < 3; ++step) {
    if (!gaussNewtonStep(matches, rows, fitted)) return false;
  }
  h = fitted;
  return true;
}

}  // namespace corrsel::core
