#include "corrsel/geometry/residual.h"

#include "corrsel/geometry/fundamental.h"
#include "corrsel/geometry/homography.h"

namespace corrsel::core {
namespace {

/// The inverse, with Frobenius norm 1 and a third coordinate that is positive where that of `h` is; zeros
/// where there is none.
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
  const cv::Matx33d backward =
      residual == Residual::kSymmetricTransfer ? inverseHomography(model) : cv::Matx33d::zeros();
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
  const auto each = [&m, out](const auto& error) {
    for (std::size_t i = 0; i < m.size(); ++i)
      out[i] = error(m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
  };
  switch (residual) {
    case Residual::kTransfer:
      each([&model](double x, double y, double u, double v) { return homographyError(model, x, y, u, v); });
      break;
    case Residual::kSymmetricTransfer:
      each([&model, backward = inverseHomography(model)](double x, double y, double u, double v) {
        return homographyError(model, x, y, u, v) + homographyError(backward, u, v, x, y);
      });
      break;
    case Residual::kSampson:
      each([&model](double x, double y, double u, double v) { return sampsonError(model, x, y, u, v); });
      break;
  }
}

}  // namespace corrsel::core
