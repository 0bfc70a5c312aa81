#include "geometry/prior_solvers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <opencv2/core.hpp>

#include "geometry/essential.h"

namespace corrsel::core {
namespace {

constexpr double kMinSine = 1e-9;         // of the angle between two epipolar planes
constexpr double kMinPolynomial = 1e-14;  // largest coefficient of a sample that determines the angle
constexpr double kMaxImaginary = 1e-7;    // of a root that is real but for rounding
// Angle that is taken off the rotation about the vertical, for which the tangent of the half angle is
// infinite at an angle that no camera is built for. Half turns are common: where the camera moves along the
// vertical, the rotation by half a turn more fits as well.
constexpr double kTurn = 1;

/// Ascending powers of q.
using Quadratic = std::array<double, 3>;
using Quartic = std::array<double, 5>;
using Sextic = std::array<double, 7>;

/// Chooses the sign of t for which more of the points lie in front of both cameras.
template <int count>
void chooseSign(const cv::Vec3d (&left)[count], const cv::Vec3d (&right)[count], Pose& pose) {
  int votes = 0;
  for (int i = 0; i < count; ++i) {
    const ScaledDepths depths = scaledDepths(pose, left[i], right[i]);
    votes += depths.left > 0 && depths.right > 0 ? 1 : 0;
    votes -= depths.left < 0 && depths.right < 0 ? 1 : 0;
  }
  if (votes < 0) pose.translation = -pose.translation;
}

/// The rotation of the frame in which `up` is the y axis.
cv::Matx33d upright(const cv::Vec3d& up) {
  cv::Vec3d b1, b2;
  translationBasis(up, b1, b2);
  return {b1[0], b1[1], b1[2], up[0], up[1], up[2], -b2[0], -b2[1], -b2[2]};
}

/// The rotation about y by the angle whose half has a tangent of q.
cv::Matx33d turned(double q) {
  const double scale = 1 / (1 + q * q), cosine = (1 - q * q) * scale, sine = 2 * q * scale;
  return {cosine, 0, sine, 0, 1, 0, -sine, 0, cosine};
}

/// The normal (R d) x d' of the epipolar plane, times 1 + q^2.
std::array<Quadratic, 3> normalOf(const cv::Vec3d& d, const cv::Vec3d& e) {
  const Quadratic x = {d[0], 2 * d[2], -d[0]}, y = {d[1], 0, d[1]}, z = {d[2], -2 * d[0], -d[2]};
  std::array<Quadratic, 3> normal;
  for (std::size_t k = 0; k < 3; ++k) {
    normal[0][k] = y[k] * e[2] - z[k] * e[1];
    normal[1][k] = z[k] * e[0] - x[k] * e[2];
    normal[2][k] = x[k] * e[1] - y[k] * e[0];
  }
  return normal;
}

/// Adds sign * a b c.
void addProduct(const Quadratic& a, const Quadratic& b, const Quadratic& c, double sign, Sextic& sum) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) sum[i + j + k] += sign * a[i] * b[j] * c[k];
    }
  }
}

/// The determinant of three normals over 1 + q^2.
Quartic angleEquation(const std::array<std::array<Quadratic, 3>, 3>& rows) {
  Sextic determinant{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    addProduct(rows[0][i], rows[1][j], rows[2][k], 1, determinant);
    addProduct(rows[0][i], rows[1][k], rows[2][j], -1, determinant);
  }
  return {determinant[0], determinant[1], determinant[2] - determinant[0], determinant[5], determinant[6]};
}

/// The root of the polynomial near q, by Newton's method.
double polished(const Quartic& c, double q) {
  for (int step = 0; step < 3; ++step) {
    const double value = (((c[4] * q + c[3]) * q + c[2]) * q + c[1]) * q + c[0];
    const double slope = ((4 * c[4] * q + 3 * c[3]) * q + 2 * c[2]) * q + c[1];
    if (slope == 0) break;
    q -= value / slope;
  }
  return q;
}

/// The real roots, as eigenvalues of the companion matrix.
int realRoots(const Quartic& c, double (&roots)[kVerticalSolutions]) {
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.diagonal(-1).setOnes();
  for (int k = 0; k < 4; ++k) companion(k, 3) = -c[static_cast<std::size_t>(k)] / c[4];
  if (!companion.allFinite()) return 0;
  const Eigen::EigenSolver<Eigen::Matrix4d> solver(companion, false);
  int count = 0;
  for (int k = 0; k < 4; ++k) {
    const std::complex<double> root = solver.eigenvalues()[k];
    if (std::abs(root.imag()) > kMaxImaginary * (1 + std::abs(root))) continue;
    roots[count++] = polished(c, root.real());
  }
  return count;
}

/// The direction orthogonal to all rows of a matrix without full rank.
/// @return false if there are several
bool nullDirection(const cv::Vec3d (&rows)[3], cv::Vec3d& direction) {
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    const cv::Vec3d& a = rows[i];
    const cv::Vec3d& b = rows[(i + 1) % 3];
    const cv::Vec3d candidate = a.cross(b);
    const double length = cv::norm(candidate);
    if (!(length > longest && length > kMinSine * cv::norm(a) * cv::norm(b))) continue;
    longest = length;
    direction = candidate / length;
  }
  return longest > 0;
}

}  // namespace

bool translationFromTwo(const cv::Matx33d& rotation, const cv::Vec3d (&left)[2], const cv::Vec3d (&right)[2],
                        cv::Vec3d& translation) {
  const cv::Vec3d first = (rotation * left[0]).cross(right[0]), second = (rotation * left[1]).cross(right[1]);
  const cv::Vec3d t = first.cross(second);
  const double length = cv::norm(t);
  if (!(length > kMinSine * cv::norm(first) * cv::norm(second))) return false;
  Pose pose{rotation, t / length};
  chooseSign(left, right, pose);
  translation = pose.translation;
  return true;
}

int posesFromThree(const cv::Vec3d& left_up, const cv::Vec3d& right_up, const cv::Vec3d (&left)[3],
                   const cv::Vec3d (&right)[3], Pose (&poses)[kVerticalSolutions]) {
  const cv::Matx33d from_left = turned(std::tan(0.5 * kTurn)) * upright(left_up);
  const cv::Matx33d from_right = upright(right_up);
  std::array<std::array<Quadratic, 3>, 3> rows;
  for (std::size_t i = 0; i < 3; ++i) rows[i] = normalOf(from_left * left[i], from_right * right[i]);
  const Quartic equation = angleEquation(rows);
  double largest = 0;
  for (const double c : equation) largest = std::max(largest, std::abs(c));
  if (!(largest > kMinPolynomial)) return 0;
  double roots[kVerticalSolutions];
  const int n_roots = realRoots(equation, roots);
  int count = 0;
  for (int k = 0; k < n_roots; ++k) {
    Pose pose;
    pose.rotation = from_right.t() * turned(roots[k]) * from_left;
    cv::Vec3d normals[3];
    for (int i = 0; i < 3; ++i) normals[i] = (pose.rotation * left[i]).cross(right[i]);
    if (!nullDirection(normals, pose.translation)) continue;
    chooseSign(left, right, pose);
    poses[count++] = pose;
  }
  return count;
}

}  // namespace corrsel::core
