#include "selectors/parts/affine_growing.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

namespace corrsel::core {
namespace {

struct Round {
  double radius;  // of the diagonal
  double rho;     // relative tolerance
};

constexpr Round kRounds[] = {
    {1.0 / 16, 0.3}, {1.0 / 8, 0.25}, {1.0 / 8, 0.2}, {1.0 / 4, 0.15}, {1.0 / 4, 0.12}};
constexpr double kLargestRadius = 1.0 / 2;  // of the diagonal
constexpr double kTolerance = 4;            // px, at least
constexpr std::size_t kLeastToGoOn = 4, kLeastAtEnd = 6;

}  // namespace

void AffineGrowing::assign(const Correspondences& matches, const std::vector<float>& weights,
                           double diagonal) {
  matches_ = &matches;
  weights_ = weights.data();
  diagonal_ = diagonal;
}

bool AffineGrowing::grow(std::uint32_t seed, const LinearMap& linear) {
  const Correspondences& m = *matches_;
  const double x = m.left_x[seed], y = m.left_y[seed], right_x = m.right_x[seed], right_y = m.right_y[seed];
  // Columns: the images of dx, dy and 1, relative to the seed.
  Eigen::Matrix<double, 3, 2> a;
  a << linear[0], linear[2], linear[1], linear[3], 0, 0;
  double least_radius = kRounds[0].radius;
  const auto findSupporters = [&](const Round& round, auto&& use) {
    supporters_.clear();
    const double reach = std::max(round.radius, least_radius) * diagonal_, squared_radius = reach * reach;
    for (std::uint32_t j = 0; j < m.size(); ++j) {
      const double dx = m.left_x[j] - x, dy = m.left_y[j] - y;
      const double ux = a(0, 0) * dx + a(1, 0) * dy + a(2, 0), uy = a(0, 1) * dx + a(1, 1) * dy + a(2, 1);
      const double squared = ux * ux + uy * uy;
      if (squared > squared_radius) continue;
      const double vx = m.right_x[j] - right_x, vy = m.right_y[j] - right_y;
      const double squared_tolerance = std::max(kTolerance * kTolerance, round.rho * round.rho * squared);
      if ((vx - ux) * (vx - ux) + (vy - uy) * (vy - uy) > squared_tolerance) continue;
      supporters_.push_back(j);
      use(weights_[j] / squared_tolerance, Eigen::Vector3d(dx, dy, 1), Eigen::RowVector2d(vx, vy));
    }
  };
  for (const Round& round : kRounds) {
    Eigen::Matrix3d normal;
    Eigen::Matrix<double, 3, 2> right_side;
    for (;; least_radius *= 2) {
      normal.setZero();
      right_side.setZero();
      findSupporters(round, [&](double weight, const Eigen::Vector3d& p, const Eigen::RowVector2d& v) {
        normal += weight * p * p.transpose();
        right_side += weight * p * v;
      });
      if (supporters_.size() >= kLeastToGoOn || least_radius >= kLargestRadius) break;
    }
    if (supporters_.size() < kLeastToGoOn) return false;
    const double tie = (normal(0, 0) + normal(1, 1)) / 2 / (2 * static_cast<double>(supporters_.size()));
    normal(0, 0) += tie;
    normal(1, 1) += tie;
    right_side.topRows<2>() += tie * a.topRows<2>();
    const Eigen::Matrix<double, 3, 2> solution = normal.ldlt().solve(right_side);
    if (!solution.allFinite()) return false;
    a = solution;
  }
  findSupporters(kRounds[std::size(kRounds) - 1], [](double, const auto&, const auto&) {});
  map_ = {a(0, 0), a(1, 0), right_x + a(2, 0) - a(0, 0) * x - a(1, 0) * y,
          a(0, 1), a(1, 1), right_y + a(2, 1) - a(0, 1) * x - a(1, 1) * y,
          0,       0,       1};
  return supporters_.size() >= kLeastAtEnd;
}

}  // namespace corrsel::core
