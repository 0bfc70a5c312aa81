#include "geometry/pose_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "geometry/essential.h"
#include "geometry/match_rays.h"
#include "geometry/rotation_vector.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxCondition = 1e12;
constexpr double kEnough = 1e-9;  // a step that lowers the loss by less than this share is the last one

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1>;

/// Its directions are the columns.
Matrix matrixOf(const PoseFreedom& freedom) {
  Matrix columns(5, freedom.size);
  for (int k = 0; k < freedom.size; ++k)
    columns.col(k) = Eigen::Map<const Vector>(freedom.directions[k].val, 5);
  return columns;
}

/// Normal equations in the directions of a PoseFreedom.
struct NormalEquations {
  Matrix hessian;
  Vector gradient;

  NormalEquations(const PoseSums& sums, const Matrix& columns) {
    const Eigen::Map<const Eigen::Matrix<double, 5, 5>> full(sums.hessian.val);  // symmetric
    hessian = columns.transpose() * full * columns;
    gradient = columns.transpose() * Eigen::Map<const Eigen::Matrix<double, 5, 1>>(sums.gradient.val);
  }

  bool isDegenerate() const {
    if (!hessian.allFinite()) return true;
    const Vector values =
        Eigen::SelfAdjointEigenSolver<Matrix>(hessian, Eigen::EigenvaluesOnly).eigenvalues();
    return !(values[0] * kMaxCondition > values[values.size() - 1]);
  }

  /// The step of Levenberg and Marquardt's method.
  Vector step(double lambda) const {
    Matrix damped = hessian;
    damped.diagonal() += lambda * hessian.diagonal();
    damped.diagonal().array() += 1e-12 * hessian.trace();
    return -damped.llt().solve(gradient);
  }
};

PoseInBasis inBasis(const Pose& pose) {
  const cv::Vec3d& t = pose.translation;
  cv::Vec3d b1, b2;
  translationBasis(t, b1, b2);
  const cv::Matx33d basis(b1[0], b1[1], b1[2], b2[0], b2[1], b2[2], t[0], t[1], t[2]);
  const cv::Matx33d rotation = basis * pose.rotation;
  PoseInBasis result;
  std::copy_n(basis.val, 9, result.basis);
  std::copy_n(rotation.val, 9, result.rotation);
  return result;
}

/// Chooses the sign of t for which more of the matches lie in front of both cameras.
void restoreSign(const RayMatches& matches, Pose& pose) {
  const SideCounts counts = kernels().pose.sides(inBasis(pose), matchRaysOf(matches));
  if (counts.reversed > counts.front) pose.translation = -pose.translation;
}

}  // namespace

PoseFreedom PoseFreedom::all() {
  PoseFreedom result;
  for (int k = 0; k < 5; ++k) result.directions[k][k] = 1;
  result.size = 5;
  return result;
}

PoseFreedom PoseFreedom::translation() {
  PoseFreedom result;
  result.directions[0][3] = result.directions[1][4] = 1;
  result.size = 2;
  return result;
}

PoseFreedom PoseFreedom::about(const cv::Vec3d& axis) {
  PoseFreedom result = translation();
  for (int k = 0; k < 3; ++k) result.directions[2][k] = axis[k];
  result.size = 3;
  return result;
}

PoseSums poseSums(const Pose& pose, const RayMatches& matches, double scale) {
  const PoseInBasis in_basis = inBasis(pose);
  double totals[kPoseSums];
  kernels().pose.sums(in_basis, matchRaysOf(matches), 1 / (scale * scale), totals);
  Eigen::Matrix<double, 5, 5> hessian;
  Eigen::Matrix<double, 5, 1> gradient;
  const double* total = totals;
  for (int i = 0; i < 5; ++i) {
    for (int j = i; j < 5; ++j) hessian(i, j) = hessian(j, i) = *total++;
    gradient[i] = *total++;
  }
  // From rotations about b1, b2 and t to those about the axes of the right camera.
  Eigen::Matrix<double, 5, 5> turn = Eigen::Matrix<double, 5, 5>::Identity();
  turn.topLeftCorner<3, 3>() = Eigen::Map<const Eigen::Matrix3d>(in_basis.basis);  // the transpose
  gradient = (turn * gradient).eval();
  hessian = (turn * hessian * turn.transpose()).eval();
  PoseSums sums;
  sums.cost = *total;
  for (int i = 0; i < 5; ++i) {
    sums.gradient[i] = gradient[i];
    for (int j = 0; j <= i; ++j) sums.hessian(i, j) = sums.hessian(j, i) = hessian(i, j);
  }
  return sums;
}

double fitPose(const RayMatches& matches, double scale, int steps, Pose& pose, const PoseFreedom& freedom) {
  const Matrix columns = matrixOf(freedom);
  PoseSums sums = poseSums(pose, matches, scale);
  if (NormalEquations(sums, columns).isDegenerate()) return kNaN;
  double lambda = 1e-3;
  for (int step = 0; step < steps; ++step) {
    const Vector directed = columns * NormalEquations(sums, columns).step(lambda);
    cv::Vec<double, 5> parameters;
    for (int k = 0; k < 5; ++k) parameters[k] = directed[k];
    const Pose next = moved(pose, parameters);
    const PoseSums next_sums = poseSums(next, matches, scale);
    const double saved = sums.cost - next_sums.cost;
    if (saved >= 0) {
      pose = next;
      sums = next_sums;
    }
    lambda *= saved >= 0 ? 0.1 : 10;
    if (std::abs(saved) <= kEnough * sums.cost) break;
  }
  restoreSign(matches, pose);
  return sums.cost;
}

Pose moved(const Pose& pose, const cv::Vec<double, 5>& step) {
  cv::Vec3d b1, b2;
  translationBasis(pose.translation, b1, b2);
  const cv::Vec3d t = pose.translation + b1 * step[3] + b2 * step[4];
  return {rotationFromVector({step[0], step[1], step[2]}) * pose.rotation, t / cv::norm(t)};
}

bool poseCovariance(const Pose& pose, const RayMatches& matches, double scale,
                    cv::Matx<double, 5, 5>& covariance, const PoseFreedom& freedom) {
  const std::size_t n = matches.size();
  if (n <= static_cast<std::size_t>(freedom.size)) return false;
  const Matrix columns = matrixOf(freedom);
  const NormalEquations equations(poseSums(pose, matches, std::numeric_limits<double>::infinity()), columns);
  if (equations.isDegenerate()) return false;
  std::vector<double> squared(n);
  squaredTangentSampson(essentialOf(pose), matches, squared.data());
  double psi_squared = 0, slope = 0, slope_squared = 0;
  for (const double r2 : squared) {
    const double x = r2 / (scale * scale), cube = (1 + x) * (1 + x) * (1 + x),
                 derivative = (1 - 3 * x) / cube;
    psi_squared += r2 / (cube * (1 + x));
    slope += derivative;
    slope_squared += derivative * derivative;
  }
  const double count = static_cast<double>(n), parameters = freedom.size;
  const double correction = 1 + parameters / count * (slope_squared * count / (slope * slope) - 1);
  const double factor =
      correction * correction * psi_squared * count / (slope * slope) * count / (count - parameters);
  const Eigen::Matrix<double, 5, 5> result =
      factor * columns * equations.hessian.llt().solve(columns.transpose());
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) covariance(i, j) = 0.5 * (result(i, j) + result(j, i));
  }
  return true;
}

}  // namespace corrsel::core
