#include "rig/deviation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace corrsel::core {
namespace {

constexpr double kSignificant = 5;  // standard deviations

using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Vector5 = Eigen::Matrix<double, 5, 1>;

}  // namespace

cv::Matx<double, 5, 5> inBasisOf(const cv::Vec3d& to, const cv::Vec3d& from,
                                 const cv::Matx<double, 5, 5>& covariance) {
  cv::Vec3d old_basis[2], new_basis[2];
  translationBasis(from, old_basis[0], old_basis[1]);
  translationBasis(to, new_basis[0], new_basis[1]);
  cv::Matx<double, 5, 5> turn = cv::Matx<double, 5, 5>::eye();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) turn(3 + i, 3 + j) = new_basis[i].dot(old_basis[j]);
  }
  return turn * covariance * turn.t();
}

cv::Vec<double, 5> significantPart(const cv::Vec<double, 5>& deviation,
                                   const cv::Matx<double, 5, 5>& covariance) {
  const Eigen::Map<const Matrix5> c(covariance.val);  // symmetric
  const Eigen::Map<const Vector5> d(deviation.val);
  if (!c.allFinite() || !d.allFinite()) {
    return cv::Vec<double, 5>::all(std::numeric_limits<double>::quiet_NaN());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix5> axes(c);
  Vector5 along = axes.eigenvectors().transpose() * d;
  for (int k = 0; k < 5; ++k) {
    const double sigma = std::sqrt(std::max(0.0, axes.eigenvalues()[k]));
    if (std::abs(along[k]) <= kSignificant * sigma) along[k] = 0;
  }
  const Vector5 part = axes.eigenvectors() * along;
  return {part[0], part[1], part[2], part[3], part[4]};
}

double angleOf(const cv::Vec<double, 5>& deviation) {
  const double rotation = cv::norm(cv::Vec3d(deviation[0], deviation[1], deviation[2]));
  return std::max(rotation, std::hypot(deviation[3], deviation[4])) * 180 / CV_PI;
}

}  // namespace corrsel::core
