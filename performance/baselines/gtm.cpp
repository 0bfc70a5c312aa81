#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>

#include "baselines.h"
#include "selectors/parts/otsu.h"

namespace corrsel::baselines {
namespace {

using Eigen::ArrayXf, Eigen::Index, Eigen::MatrixXf, Eigen::VectorXf;

constexpr float kLambda = 1e-4F;
constexpr float kTiny = 1e-30F;
constexpr int kSteps = 100, kBins = 256;

/// exp(-lambda max(e_ij, e_ji)), e_ij = L1 distance between the right point of match i and where match j's
/// affine map puts its left point; 0 on the diagonal and for matches that share a point.
MatrixXf payoffs(const core::Correspondences& m) {
  const Index n = Index(m.size());
  const Eigen::Map<const ArrayXf> x(m.left_x.data(), n), y(m.left_y.data(), n), u(m.right_x.data(), n),
      v(m.right_y.data(), n);
  ArrayXf a11(n), a12(n), a21(n), a22(n);
  for (Index i = 0; i < n; ++i) {
    const core::AffineFrame &left = m.left_frame[std::size_t(i)], &right = m.right_frame[std::size_t(i)];
    Eigen::Matrix2f l, r;
    l << left[0], left[1], left[3], left[4];
    r << right[0], right[1], right[3], right[4];
    const Eigen::Matrix2f a = r * l.inverse();
    a11(i) = a(0, 0), a12(i) = a(0, 1), a21(i) = a(1, 0), a22(i) = a(1, 1);
  }
  MatrixXf payoff(n, n);
  ArrayXf dx(n), dy(n), du(n), dv(n);
  for (Index j = 0; j < n; ++j) {
    dx = x - x(j), dy = y - y(j), du = u - u(j), dv = v - v(j);
    payoff.col(j) =
        (-kLambda * ((du - a11(j) * dx - a12(j) * dy).abs() + (dv - a21(j) * dx - a22(j) * dy).abs())
                        .max((du - a11 * dx - a12 * dy).abs() + (dv - a21 * dx - a22 * dy).abs()))
            .exp();
    // Times 0 where a point is shared, times 1 elsewhere.
    payoff.col(j).array() *= (dx.abs() + dy.abs()).min(du.abs() + dv.abs()).min(kTiny) * (1 / kTiny);
  }
  return payoff;
}

}  // namespace

Mask gtmDense(const core::Correspondences& m) {
  const Index n = Index(m.size());
  Mask mask(m.size(), 0);
  if (m.size() < 2) return mask;
  const MatrixXf payoff = payoffs(m);
  VectorXf q = VectorXf::Constant(n, 1 / float(n)), gain(n);
  for (int step = 0; step < kSteps; ++step) {
    gain.noalias() = payoff * q;
    const float mean = q.dot(gain);
    if (!(mean > 0)) return mask;
    q.array() *= gain.array() / mean;
  }
  const std::vector<double> values(q.data(), q.data() + n);
  const auto threshold = core::otsuThreshold(values, q.minCoeff(), q.maxCoeff(), kBins);
  for (std::size_t i = 0; i < m.size(); ++i) mask[i] = !threshold || values[i] > *threshold;
  return mask;
}

}  // namespace corrsel::baselines
