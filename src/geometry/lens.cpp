#include "geometry/lens.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace corrsel::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxDegree = 6;

/// Coefficients, the constant first.
using Polynomial = std::array<double, kMaxDegree + 1>;

double valueAt(const Polynomial& p, double x) {
  double sum = 0;
  for (std::size_t i = p.size(); i-- > 0;) sum = sum * x + p[i];
  return sum;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial result{};
  for (std::size_t i = 1; i < p.size(); ++i) result[i - 1] = static_cast<double>(i) * p[i];
  return result;
}

/// A root between two places where the polynomial has different signs, by bisection.
double rootBetween(const Polynomial& p, double low, double high) {
  constexpr int kSteps = 100;
  const bool rises = valueAt(p, high) > 0;
  for (int step = 0; step < kSteps; ++step) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    ((valueAt(p, middle) > 0) == rises ? high : low) = middle;
  }
  return low;
}

struct Roots {
  std::array<double, kMaxDegree> value;
  std::size_t count = 0;
};

/// The places in (0, end) where the polynomial changes its sign, ascending: at most one between neighbouring
/// extrema, which are the roots of its derivative.
Roots rootsOf(const Polynomial& p, std::size_t degree, double end) {
  Roots roots;
  if (degree == 0) return roots;
  const Roots extrema = rootsOf(derivative(p), degree - 1, end);
  double low = 0;
  for (std::size_t i = 0; i <= extrema.count; ++i) {
    const double high = i < extrema.count ? extrema.value[i] : end;
    if ((valueAt(p, low) > 0) != (valueAt(p, high) > 0)) {
      roots.value[roots.count++] = rootBetween(p, low, high);
    }
    low = high;
  }
  return roots;
}

/// The smallest positive number below `end` where a polynomial changes its sign, +Inf without one.
double firstRoot(const Polynomial& p, double end) {
  // Descartes: without a change of sign among the coefficients there is no positive root.
  if (std::all_of(p.begin(), p.end(), [](double value) { return value >= 0; })) return kInfinity;
  std::size_t degree = kMaxDegree;
  while (degree > 0 && p[degree] == 0) --degree;
  const Roots roots = rootsOf(p, degree, end);
  return roots.count > 0 ? roots.value[0] : kInfinity;
}

/// r^2 at which the radial distortion turns or has a pole. Tangential distortion, which is small, is left to
/// the determinant.
double pinholeLimit(const std::array<double, 8>& k) {
  constexpr double kLargest = 1e8;  // 0.006 degrees from the image plane
  const std::array<double, 4> above = {1, k[0], k[1], k[4]}, below = {1, k[5], k[6], k[7]};
  // The numerator of the derivative of r above(r^2) / below(r^2) by r.
  Polynomial slope{}, pole{};
  for (std::size_t i = 0; i < 4; ++i) {
    pole[i] = below[i];
    for (std::size_t j = 0; j < 4; ++j) {
      const double factor = 1.0 + 2.0 * static_cast<double>(i) - 2.0 * static_cast<double>(j);
      slope[i + j] += factor * above[i] * below[j];
    }
  }
  return std::min(firstRoot(slope, kLargest), firstRoot(pole, kLargest));
}

/// The angle at which the radius of a fisheye image turns, at most pi.
double fisheyeLimit(const std::array<double, 8>& k) {
  const Polynomial slope = {1, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3], 0, 0};
  return std::min(CV_PI, std::sqrt(firstRoot(slope, CV_PI * CV_PI)));
}

}  // namespace

PreparedLens prepareLens(const Camera& camera) {
  PreparedLens prepared{};
  LensModel& model = prepared.model;
  std::copy(camera.distortion.begin(), camera.distortion.end(), model.distortion);
  model.limit = kInfinity;
  if (camera.model == Camera::Model::kEquirectangular) {
    prepared.kind = LensKind::kEquirectangular;
    model.inverse_fx = 1.0 / camera.size.width;
    model.inverse_fy = 1.0 / camera.size.height;
    return prepared;
  }
  const cv::Matx33d& k = camera.matrix;
  model.inverse_fx = 1.0 / k(0, 0);
  model.inverse_fy = 1.0 / k(1, 1);
  model.skew = k(0, 1);
  model.cx = k(0, 2);
  model.cy = k(1, 2);
  if (camera.model == Camera::Model::kFisheye) {
    prepared.kind = LensKind::kFisheye;
    model.limit = fisheyeLimit(camera.distortion);
  } else if (camera.isPlainPinhole()) {
    prepared.kind = LensKind::kPlainPinhole;
  } else {
    const std::array<double, 8>& d = camera.distortion;
    prepared.kind = d[5] == 0 && d[6] == 0 && d[7] == 0 ? LensKind::kPinhole : LensKind::kRationalPinhole;
    model.limit = pinholeLimit(d);
  }
  return prepared;
}

}  // namespace corrsel::core
