#include <Eigen/Core>
#include <algorithm>
#include <numeric>

#include "baselines.h"

namespace corrsel::baselines {
namespace {

using Eigen::ArrayXf, Eigen::Index, Eigen::MatrixXf, Eigen::VectorXf;

constexpr float kConflict = 0.3F, kTolerance = 1e-6F;
constexpr float kTiny = 1e-30F;  // makes 0 / 0 one, changes no other ratio
constexpr int kMaxSteps = 1000;

/// min(d/d', d'/d) of the distances between two matches in the two images; 1 for identical matches, 0 where
/// only one distance is 0, and on the diagonal.
MatrixXf affinities(const core::Correspondences& m) {
  const Index n = Index(m.size());
  const Eigen::Map<const ArrayXf> x(m.left_x.data(), n), y(m.left_y.data(), n), u(m.right_x.data(), n),
      v(m.right_y.data(), n);
  MatrixXf a(n, n);
  ArrayXf left(n), right(n);
  for (Index j = 0; j < n; ++j) {
    left = (x - x(j)).square() + (y - y(j)).square();
    right = (u - u(j)).square() + (v - v(j)).square();
    a.col(j) = ((left.min(right) + kTiny) / (left.max(right) + kTiny)).sqrt();
    a(j, j) = 0;
  }
  return a;
}

VectorXf principalEigenvector(const MatrixXf& a) {
  VectorXf v = VectorXf::Constant(a.rows(), 1 / std::sqrt(float(a.rows()))), next(a.rows());
  for (int step = 0; step < kMaxSteps; ++step) {
    next.noalias() = a * v;
    const float norm = next.norm();
    if (!(norm > 0)) break;
    next /= norm;
    const float change = (next - v).norm();
    v.swap(next);
    if (change < kTolerance) break;
  }
  return v;
}

}  // namespace

Mask stDense(const core::Correspondences& m) {
  Mask mask(m.size(), 0);
  if (m.empty()) return mask;
  const MatrixXf a = affinities(m);
  const VectorXf v = principalEigenvector(a);
  std::vector<Index> order(m.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&v](Index i, Index j) { return v(i) > v(j); });
  std::vector<std::uint8_t> dropped(m.size(), 0);
  for (const Index i : order) {
    if (!(v(i) > 0) || dropped[std::size_t(i)]) continue;
    mask[std::size_t(i)] = 1;
    const float* affinity = a.col(i).data();
    for (std::size_t j = 0; j < dropped.size(); ++j) dropped[j] |= affinity[j] <= kConflict;
  }
  return mask;
}

}  // namespace corrsel::baselines
