#include "geometry/residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/essential.h"
#include "geometry/homography.h"
#include "geometry/rotation.h"

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

void repairedErrors(const cv::Matx33d& essential, const RayColumns& rays, std::size_t shift, float* out) {
  const ResidualModel model = residualModel(Residual::kTangentSampson, essential);
  const auto errors = kernels().residuals.errors[static_cast<std::size_t>(Residual::kTangentSampson)];
  const std::size_t n = rays.size;
  const float *const left = rays.left.data(), *const right = rays.right.data();
  MatchColumns columns = {nullptr, nullptr, nullptr, nullptr, n, left, right + shift, n};
  errors(model, columns, 0, n - shift, out);
  columns.left_rays = left + (n - shift);
  columns.right_rays = right;
  errors(model, columns, 0, shift, out + (n - shift));
}

void pixelErrors(Residual residual, const cv::Matx33d& model, const Correspondences& m, double* out) {
  const std::size_t n = m.size();
  const float *const x = m.left_x.data(), *const y = m.left_y.data();
  const float *const u = m.right_x.data(), *const v = m.right_y.data();
  if (residual == Residual::kSampson) {
    kernels().residuals.pixel_sampson(model.val, {x, y, u, v, n}, 0, n, out);
    return;
  }
  const auto errors = kernels().residuals.pixel_transfer;
  errors(model.val, {x, y, u, v, n}, 0, n, out);
  if (residual == Residual::kTransfer) return;
  const cv::Matx33d inverse = inverseHomography(model);
  constexpr std::size_t kBlock = 256;
  double backward[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    double* const error = out + begin;
    errors(inverse.val, {u, v, x, y, n}, begin, begin + count, backward);
    if (residual == Residual::kSymmetricTransfer) {
      for (std::size_t i = 0; i < count; ++i) error[i] += backward[i];
    } else {
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < count; ++i) {
        // There are no branches, so that the loop is vectorised.
        const double smaller = backward[i] < error[i] ? backward[i] : error[i];
        const double known = error[i] < kInfinity ? smaller : kInfinity;
        error[i] = backward[i] < kInfinity ? known : kInfinity;
      }
    }
  }
}

void rayErrors(ModelKind kind, const cv::Matx33d& model, const RayMatches& rays,
               std::vector<double>& errors) {
  errors.resize(rays.size());
  if (kind == ModelKind::kEssential) {
    squaredTangentSampson(model, rays, errors.data());
  } else {
    for (std::size_t i = 0; i < rays.size(); ++i) errors[i] = squaredRotationError(model, rays, i);
  }
}

void selectionErrors(ModelKind kind, const cv::Matx33d& model, const Correspondences& matches,
                     RayMatches& rays, std::vector<double>& errors) {
  const std::size_t n = matches.size();
  errors.resize(n);
  if (kind == ModelKind::kHomography || kind == ModelKind::kFundamental) {
    const bool homography = kind == ModelKind::kHomography;
    pixelErrors(homography ? Residual::kSmallerTransfer : Residual::kSampson, model, matches, errors.data());
    return;
  }
  unproject(*matches.left_camera, matches.left_x.data(), matches.left_y.data(), n, rays.left);
  unproject(*matches.right_camera, matches.right_x.data(), matches.right_y.data(), n, rays.right);
  rayErrors(kind, model, rays, errors);
}

}  // namespace corrsel::core
