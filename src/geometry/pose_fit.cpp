#include "geometry/pose_fit.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "geometry/cross_matrix.h"
#include "geometry/essential.h"

namespace corrsel::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxCondition = 1e12;
constexpr double kEnough = 1e-9;  // a step that lowers the loss by less than this share is the last one

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1>;

/// The columns of a PoseFreedom.
Matrix columnsOf(const PoseFreedom& freedom) {
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

/// Chooses the sign of t for which more of the matches lie in front of both cameras.
void restoreSign(const RayMatches& matches, Pose& pose) {
  std::size_t positive = 0, negative = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const ScaledDepths depths = scaledDepths(pose, matches.left.direction(i), matches.right.direction(i));
    positive += depths.left > 0 && depths.right > 0 ? 1 : 0;
    negative += depths.left < 0 && depths.right < 0 ? 1 : 0;
  }
  if (negative > positive) pose.translation = -pose.translation;
}

cv::Matx33d exponential(const cv::Vec3d& w) {
  const double squared = w.dot(w), angle = std::sqrt(squared);
  const bool small = angle < 1e-4;  // below it the series are exact
  const double first = small ? 1 - squared / 6 : std::sin(angle) / angle;
  const double half = std::sin(0.5 * angle);
  const double second = small ? 0.5 - squared / 24 : 2 * half * half / squared;
  const cv::Matx33d cross = crossMatrix(w);
  return cv::Matx33d::eye() + cross * first + cross * cross * second;
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
  PoseSums sums;
  const cv::Vec3d t = pose.translation;
  cv::Vec3d b1, b2;
  translationBasis(t, b1, b2);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const cv::Vec3d left = matches.left.direction(i), right = matches.right.direction(i);
    const cv::Matx<double, 3, 2> j1 = pose.rotation * matches.left.jacobian(i),
                                 j2 = matches.right.jacobian(i);
    const cv::Vec3d a = pose.rotation * left, l = t.cross(a), n = right.cross(t);
    const cv::Vec2d p = j1.t() * n, q = j2.t() * l;
    const double denominator = p.dot(p) + q.dot(q) + 1e-30, c = right.dot(l), k = c / denominator;
    const double root = std::sqrt(denominator), r = c / root;
    const cv::Vec3d g = a - j1 * p * k, h = j2 * q * k;
    const cv::Vec3d dw = (g.cross(n) - a.cross(h.cross(t))) / root, dt = (g.cross(right) - a.cross(h)) / root;
    const cv::Vec<double, 5> jacobian(dw[0], dw[1], dw[2], dt.dot(b1), dt.dot(b2));
    const double x = 1 + r * r / (scale * scale), w = 1 / (x * x);
    sums.cost += r * r / x;
    sums.gradient += jacobian * (w * r);
    sums.hessian += jacobian * jacobian.t() * w;
  }
  return sums;
}

double fitPose(const RayMatches& matches, double scale, int steps, Pose& pose, const PoseFreedom& freedom) {
  const Matrix columns = columnsOf(freedom);
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
  return {exponential({step[0], step[1], step[2]}) * pose.rotation, t / cv::norm(t)};
}

bool poseCovariance(const Pose& pose, const RayMatches& matches, double scale,
                    cv::Matx<double, 5, 5>& covariance, const PoseFreedom& freedom) {
  const std::size_t n = matches.size();
  if (n <= static_cast<std::size_t>(freedom.size)) return false;
  const Matrix columns = columnsOf(freedom);
  const NormalEquations equations(poseSums(pose, matches, std::numeric_limits<double>::infinity()), columns);
  if (equations.isDegenerate()) return false;
  std::vector<double> squared(n);
  squaredTangentSampson(essentialOf(pose), matches, squared.data());
  double psi_squared = 0, slope = 0;
  for (const double r2 : squared) {
    const double x = r2 / (scale * scale), cube = (1 + x) * (1 + x) * (1 + x);
    psi_squared += r2 / (cube * (1 + x));
    slope += (1 - 3 * x) / cube;
  }
  const double count = static_cast<double>(n);
  const double factor = psi_squared * count / (slope * slope) * count / (count - freedom.size);
  const Eigen::Matrix<double, 5, 5> result =
      factor * columns * equations.hessian.llt().solve(columns.transpose());
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) covariance(i, j) = 0.5 * (result(i, j) + result(j, i));
  }
  return true;
}

}  // namespace corrsel::core
