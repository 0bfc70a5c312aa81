#include "search/affine_growing.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr AffineGrowing::Round kRounds[] = {
    {1.0 / 16, 0.3}, {1.0 / 8, 0.25}, {1.0 / 8, 0.2}, {1.0 / 4, 0.15}, {1.0 / 4, 0.12}};
constexpr double kMaxRadius = 1.0 / 2;  // of the diagonal
constexpr double kTolerance = 4;        // px, at least
constexpr std::size_t kMinToGoOn = 4, kMinAtEnd = 6;

/// One row each for dx, dy and 1, one column for each coordinate.
using Solution = Eigen::Matrix<double, 3, 2>;

std::array<float, 6> mapOf(const Solution& solution) {
  std::array<float, 6> map{};
  for (std::size_t i = 0; i < map.size(); ++i)
    map[i] = static_cast<float>(solution(static_cast<Eigen::Index>(i / 2), static_cast<Eigen::Index>(i % 2)));
  return map;
}

}  // namespace

void AffineGrowing::assign(const Correspondences& matches, const std::vector<float>& weights,
                           double diagonal) {
  matches_ = &matches;
  weights_ = weights.data();
  diagonal_ = diagonal;
}

void AffineGrowing::findSupporters(const Round& round, double reach, const Map& p) {
  const Correspondences& m = *matches_;
  GrowingMap map{};
  std::copy(p.begin(), p.end(), map.p);
  map.left_x = m.left_x[seed_];
  map.left_y = m.left_y[seed_];
  map.right_x = m.right_x[seed_];
  map.right_y = m.right_y[seed_];
  map.squared_radius = static_cast<float>(reach * reach);
  map.squared_rho = static_cast<float>(round.rho * round.rho);
  map.squared_floor = static_cast<float>(kTolerance * kTolerance);
  const MatchColumns columns = {m.left_x.data(), m.left_y.data(), m.right_x.data(), m.right_y.data(),
                                m.size()};
  const std::size_t count = kernels().support.supporters(columns, map, found_.data(), tolerances_.data());
  supporters_.assign(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count));
}

bool AffineGrowing::grow(std::uint32_t seed, const LinearMap& linear) {
  const Correspondences& m = *matches_;
  seed_ = seed;
  found_.resize(m.size() + SupportKernels::kMaxVectorLength);
  tolerances_.resize(m.size() + SupportKernels::kMaxVectorLength);
  const double x = m.left_x[seed], y = m.left_y[seed], right_x = m.right_x[seed], right_y = m.right_y[seed];
  Solution a;
  a << linear[0], linear[2], linear[1], linear[3], 0, 0;
  double min_radius = kRounds[0].radius;
  for (const Round& round : kRounds) {
    for (;; min_radius *= 2) {
      findSupporters(round, std::max(round.radius, min_radius) * diagonal_, mapOf(a));
      if (supporters_.size() >= kMinToGoOn || min_radius >= kMaxRadius) break;
    }
    if (supporters_.size() < kMinToGoOn) return false;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Solution right_side = Solution::Zero();
    for (std::size_t k = 0; k < supporters_.size(); ++k) {
      const std::uint32_t j = supporters_[k];
      const double weight = weights_[j] / double{tolerances_[k]};
      const Eigen::Vector3d p(m.left_x[j] - x, m.left_y[j] - y, 1);
      normal += weight * p * p.transpose();
      right_side += weight * p * Eigen::RowVector2d(m.right_x[j] - right_x, m.right_y[j] - right_y);
    }
    const double tie = (normal(0, 0) + normal(1, 1)) / 2 / (2 * static_cast<double>(supporters_.size()));
    normal(0, 0) += tie;
    normal(1, 1) += tie;
    right_side.topRows<2>() += tie * a.topRows<2>();
    const Solution solution = normal.ldlt().solve(right_side);
    if (!solution.allFinite()) return false;
    a = solution;
  }
  const Round& last = kRounds[std::size(kRounds) - 1];
  findSupporters(last, std::max(last.radius, min_radius) * diagonal_, mapOf(a));
  map_ = {a(0, 0), a(1, 0), right_x + a(2, 0) - a(0, 0) * x - a(1, 0) * y,
          a(0, 1), a(1, 1), right_y + a(2, 1) - a(0, 1) * x - a(1, 1) * y,
          0,       0,       1};
  return supporters_.size() >= kMinAtEnd;
}

}  // namespace corrsel::core
