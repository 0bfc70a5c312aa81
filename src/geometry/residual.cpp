#include "geometry/residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/fundamental.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

/// Returns the inverse with Frobenius norm 1 and the sign that keeps third coordinates positive where those
/// of `h` are; zeros if there is no inverse.
cv::Matx33d inverseHomography(const cv::Matx33d& h) {
  const cv::Matx33d adjugate = adjugateOf(h);
  const double determinant = h(0, 0) * adjugate(0, 0) + h(0, 1) * adjugate(1, 0) + h(0, 2) * adjugate(2, 0);
  const double norm = cv::norm(adjugate);
  return determinant == 0 || !(norm > 0) ? cv::Matx33d::zeros()
                                         : adjugate * ((determinant > 0 ? 1 : -1) / norm);
}

}  // namespace

ResidualModel residualModel(Residual residual, const cv::Matx33d& model) {
  ResidualModel result{};
  const bool two_way = residual == Residual::kSymmetricTransfer || residual == Residual::kSmallerTransfer;
  const cv::Matx33d backward = two_way ? inverseHomography(model) : cv::Matx33d::zeros();
  for (int i = 0; i < 9; ++i) {
    result.forward[i] = static_cast<float>(model.val[i]);
    result.backward[i] = static_cast<float>(backward.val[i]);
  }
  return result;
}

void modelErrors(Residual residual, const cv::Matx33d& model, const NormalizedMatches& matches,
                 std::size_t begin, std::size_t end, float* out) {
  kernels().residuals.errors[static_cast<std::size_t>(residual)](residualModel(residual, model),
                                                                 matches.columns(), begin, end, out);
}

void pixelErrors(Residual residual, const cv::Matx33d& model, const Correspondences& m, double* out) {
  const float *const x = m.left_x.data(), *const y = m.left_y.data();
  const float *const u = m.right_x.data(), *const v = m.right_y.data();
  const std::size_t n = m.size();
  // `out` cannot point into these copies, so the compiler can vectorise the loops.
  const cv::Matx33d forward = model, backward = inverseHomography(model);
  switch (residual) {
    case Residual::kTransfer:
      for (std::size_t i = 0; i < n; ++i) out[i] = homographyError(forward, x[i], y[i], u[i], v[i]);
      break;
    case Residual::kSymmetricTransfer:
      for (std::size_t i = 0; i < n; ++i) out[i] = homographyError(forward, x[i], y[i], u[i], v[i]);
      for (std::size_t i = 0; i < n; ++i) out[i] += homographyError(backward, u[i], v[i], x[i], y[i]);
      break;
    case Residual::kSmallerTransfer:
      for (std::size_t i = 0; i < n; ++i) out[i] = homographyError(forward, x[i], y[i], u[i], v[i]);
      for (std::size_t i = 0; i < n; ++i) {
        const double back = homographyError(backward, u[i], v[i], x[i], y[i]);
        const bool exists = std::isfinite(out[i]) && std::isfinite(back);
        out[i] = exists ? std::min(out[i], back) : std::numeric_limits<double>::infinity();
      }
      break;
    case Residual::kSampson:
      for (std::size_t i = 0; i < n; ++i) out[i] = sampsonError(forward, x[i], y[i], u[i], v[i]);
      break;
  }
}

}  // namespace corrsel::core
