#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <set>
#include <utility>

#include "baselines.h"
#include "corrsel/random.h"

namespace corrsel::baselines {
namespace {

using Eigen::ArrayXd, Eigen::Index, Eigen::MatrixX2d, Eigen::MatrixXd;

// The authors' defaults; 50 steps as in their C++ code.
constexpr double kBeta = 0.1, kLambda = 3, kTheta = 0.75, kGamma = 0.9, kOutlierArea = 10;
constexpr double kMinProbability = 1e-5, kMinSigma2 = 1e-8, kEnergyChange = 1e-5;
constexpr int kMaxSteps = 50;
constexpr std::size_t kControlPoints = 16;

/// Centred, scaled to unit root mean square radius.
MatrixX2d normalised(const std::vector<float>& x, const std::vector<float>& y) {
  MatrixX2d points(Index(x.size()), 2);
  for (Index i = 0; i < points.rows(); ++i) points.row(i) << x[std::size_t(i)], y[std::size_t(i)];
  points.rowwise() -= points.colwise().mean();
  return points / std::sqrt(points.rowwise().squaredNorm().mean());
}

/// exp(-beta |a_i - b_j|^2)
MatrixXd kernel(const MatrixX2d& a, const MatrixX2d& b) {
  MatrixXd k(a.rows(), b.rows());
  for (Index j = 0; j < b.rows(); ++j) {
    k.col(j) =
        (-kBeta * ((a.col(0).array() - b(j, 0)).square() + (a.col(1).array() - b(j, 1)).square())).exp();
  }
  return k;
}

/// The EM of both variants. `solve(p, sigma2)` is the M step: it returns the field at the matches and the
/// norm of the field, tr(C^T K C).
template <class Solve>
Mask expectationMaximisation(const MatrixX2d& y, const Solve& solve) {
  const double n = double(y.rows());
  MatrixX2d field = MatrixX2d::Zero(y.rows(), 2);
  double sigma2 = y.squaredNorm() / (2 * n), gamma = kGamma, energy = 1, norm = 0, change = 1;
  ArrayXd p = ArrayXd::Zero(y.rows());
  for (int step = 1; step < kMaxSteps && change > kEnergyChange && sigma2 > kMinSigma2; ++step) {
    const ArrayXd r2 = (y - field).rowwise().squaredNorm();
    const ArrayXd e = (-r2 / (2 * sigma2)).exp();
    p = e / (e + 2 * M_PI * sigma2 * (1 - gamma) / (gamma * kOutlierArea));
    const double previous = std::exchange(
        energy, (p * r2).sum() / (2 * sigma2) + p.sum() * std::log(sigma2) + kLambda / 2 * norm);
    change = std::abs((energy - previous) / energy);
    const ArrayXd weight = p.max(kMinProbability);
    std::tie(field, norm) = solve(weight, sigma2);
    sigma2 = (weight * (y - field).rowwise().squaredNorm().array()).sum() / (2 * weight.sum());
    gamma = std::min(std::max(double((p > kTheta).count()) / n, 0.05), 0.95);
  }
  Mask mask(std::size_t(y.rows()));
  for (Index i = 0; i < y.rows(); ++i) mask[std::size_t(i)] = p(i) > kTheta;
  return mask;
}

}  // namespace

Mask vfcDense(const core::Correspondences& m) {
  const MatrixX2d x = normalised(m.left_x, m.left_y), y = normalised(m.right_x, m.right_y) - x;
  const MatrixXd k = kernel(x, x);
  return expectationMaximisation(y, [&](const ArrayXd& p, double sigma2) {
    MatrixXd system = k;
    system.diagonal().array() += kLambda * sigma2 / p;
    const MatrixX2d c = Eigen::LLT<Eigen::Ref<MatrixXd>>(system).solve(y);
    const MatrixX2d field = k * c;
    return std::pair<MatrixX2d, double>(field, c.cwiseProduct(field).sum());
  });
}

Mask vfcSparse(const core::Correspondences& m) {
  const MatrixX2d x = normalised(m.left_x, m.left_y), y = normalised(m.right_x, m.right_y) - x;
  core::Random random(0);
  std::set<std::pair<double, double>> chosen;
  for (int tries = 0; chosen.size() < kControlPoints && tries < 10 * int(kControlPoints); ++tries) {
    const Index i = Index(random.index(std::uint32_t(m.size())));
    chosen.insert({x(i, 0), x(i, 1)});
  }
  MatrixX2d control(Index(chosen.size()), 2);
  Index row = 0;
  for (const auto& [a, b] : chosen) control.row(row++) << a, b;
  const MatrixXd u = kernel(x, control), k = kernel(control, control);
  return expectationMaximisation(y, [&](const ArrayXd& p, double sigma2) {
    const MatrixXd weighted = u.array().colwise() * p;
    const MatrixXd system = weighted.transpose() * u + kLambda * sigma2 * k;
    const MatrixX2d c = system.ldlt().solve(weighted.transpose() * y);
    return std::pair<MatrixX2d, double>(u * c, c.cwiseProduct(k * c).sum());
  });
}

}  // namespace corrsel::baselines
