#include "rig/rig_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>

#include "corrsel/random.h"
#include "geometry/essential.h"

namespace corrsel::core {
namespace {

using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Vector5 = Eigen::Matrix<double, 5, 1>;

constexpr double kScale = 3;              // of the loss, times the noise
constexpr double kMinNoise = 0.1;         // px
constexpr int kRounds = 12, kSteps = 15;  // of the scale, and of the fit in each round
constexpr double kEnough = 0.95;          // a scale that falls by less is the last one
constexpr double kMaxAngle = 20 * CV_PI / 180;
constexpr std::size_t kMinGroups = 9;
constexpr std::uint64_t kSeed = 0;

double angleOf(const Pose& a, const Pose& b) {
  const cv::Matx33d r = a.rotation * b.rotation.t();
  const double turn = std::acos(std::clamp(0.5 * (cv::trace(r) - 1), -1.0, 1.0));
  return std::max(turn, std::acos(std::clamp(a.translation.dot(b.translation), -1.0, 1.0)));
}

void append(const std::vector<double>& values, std::vector<double>& to) {
  to.insert(to.end(), values.begin(), values.end());
}

}  // namespace

/// Puts the matches of all pairs in random order, which the refinement wants.
void RigFit::gather(const RigWindow& window) {
  RayMatches in_order;
  std::vector<std::uint32_t> pair_of, region_of, rows;
  std::uint32_t number = 0;
  for (const RigWindow::Pair& pair : window.pairs()) {
    for (std::size_t c = 0; c < Rays::kColumns; ++c) {
      append(pair.rays.left.column[c], in_order.left.column[c]);
      append(pair.rays.right.column[c], in_order.right.column[c]);
    }
    pair_of.resize(in_order.size(), number++);
    region_of.insert(region_of.end(), pair.regions.begin(), pair.regions.end());
  }
  rows.resize(pair_of.size());
  std::iota(rows.begin(), rows.end(), 0U);
  Random(kSeed).shuffle(rows);
  gatherRays(in_order, rows, all_);
  pairs_.clear();
  regions_.clear();
  for (const std::uint32_t row : rows) {
    pairs_.push_back(pair_of[row]);
    regions_.push_back(region_of[row]);
  }
  std::iota(rows.begin(), rows.end(), 0U);
  columns_.take(all_, rows);
}

/// Standard deviation of the errors of the inliers, px, from the quantile q of the errors' magnitudes.
/// @param of_normal  this quantile of the magnitudes of standard normal numbers
double RigFit::noise(const Pose& pose, double q, double of_normal) {
  errors_.resize(all_.size());
  squaredTangentSampson(essentialOf(pose), all_, errors_.data());
  const auto found =
      errors_.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(errors_.size() - 1));
  std::nth_element(errors_.begin(), found, errors_.end());
  return std::max(kMinNoise, std::sqrt(*found) / of_normal);
}

/// Fits the pose to all matches, with a loss that becomes narrower. It begins wide enough for a pose that
/// most of the matches contradict. The noise is taken from the lower quartile, of which an object that moves
/// by itself makes less than of the median.
/// @return the noise, px
std::optional<double> RigFit::approach(Pose& pose) {
  double scale = kScale * noise(pose, 0.75, 1.1503), sigma = 0;
  for (int round = 0; round < kRounds; ++round) {
    if (std::isnan(fitPose(all_, scale, kSteps, pose))) return std::nullopt;
    sigma = noise(pose, 0.25, 0.3186);
    const double next = std::max(kScale * sigma, 0.5 * scale);
    if (next > kEnough * scale) break;
    scale = next;
  }
  return sigma;
}

std::optional<RigEstimate> RigFit::fit(const RigWindow& window, const Pose& start) {
  gather(window);
  if (all_.size() == 0) return std::nullopt;
  RigEstimate estimate{start, {}, {}, 0};
  const std::optional<double> sigma = approach(estimate.pose);
  if (!sigma) return std::nullopt;
  estimate.noise = *sigma;
  const double scale = kScale * estimate.noise;
  if (!refinement_.refine(all_, columns_, scale, true, nullptr, PoseFreedom::all(), estimate.pose)) {
    return std::nullopt;
  }
  if (!(angleOf(estimate.pose, start) < kMaxAngle)) return std::nullopt;
  if (!poseCovariance(estimate.pose, refinement_.fitted(), scale, estimate.covariance)) return std::nullopt;
  if (!addCommonNoise(estimate.pose, scale, pairs_, estimate.covariance)) return std::nullopt;
  estimate.cautious = estimate.covariance;
  if (!addCommonNoise(estimate.pose, scale, regions_, estimate.cautious)) return std::nullopt;
  return estimate;
}

/// Enlarges a covariance along the directions in which the sums over groups of matches vary by more than it
/// explains.
/// @param groups  of each match
/// @return false if the covariance is not positive definite
bool RigFit::addCommonNoise(const Pose& pose, double scale, const std::vector<std::uint32_t>& groups,
                            cv::Matx<double, 5, 5>& covariance) const {
  const Eigen::LLT<Matrix5> root(Eigen::Map<const Matrix5>(covariance.val));  // symmetric
  if (root.info() != Eigen::Success) return false;
  std::map<std::uint32_t, std::vector<std::uint32_t>> rows;
  for (const std::uint32_t row : refinement_.rows()) rows[groups[row]].push_back(row);
  if (rows.size() < kMinGroups) return true;
  Matrix5 scatter = Matrix5::Zero();
  RayMatches rays;
  for (const auto& [group, of_group] : rows) {
    gatherRays(all_, of_group, rays);
    const PoseSums sums = poseSums(pose, rays, scale);
    const Eigen::Map<const Vector5> sum(sums.gradient.val);
    scatter += sum * sum.transpose();
  }
  const double n = static_cast<double>(rows.size());
  const PoseSums sums = poseSums(pose, refinement_.fitted(), std::numeric_limits<double>::infinity());
  const Matrix5 inverse = (slope(scale) * Eigen::Map<const Matrix5>(sums.hessian.val)).inverse();
  const Matrix5 sandwich = n / (n - 1) * inverse * scatter * inverse;
  const Matrix5 half = root.matrixL().solve(sandwich);
  const Matrix5 ratio = root.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(0.5 * (ratio + ratio.transpose()));
  const Matrix5 columns = Matrix5(root.matrixL()) * solver.eigenvectors();
  const Matrix5 result = columns * solver.eigenvalues().cwiseMax(1).asDiagonal() * columns.transpose();
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) covariance(i, j) = 0.5 * (result(i, j) + result(j, i));
  }
  return true;
}

/// Mean derivative of psi over the fitted matches, which makes the Hessian of the loss out of sum J J^T.
double RigFit::slope(double scale) const {
  double sum = 0;
  for (const std::uint32_t row : refinement_.rows()) {
    const double x = refinement_.errors()[row] / (scale * scale);
    sum += (1 - 3 * x) / ((1 + x) * (1 + x) * (1 + x));
  }
  return sum / static_cast<double>(refinement_.rows().size());
}

}  // namespace corrsel::core
