#include "calibrated/plane_poses.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "corrsel/random.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"

namespace corrsel::core {
namespace {

constexpr int kTriples = 100, kRounds = 3, kSteps = 6;
constexpr std::size_t kScored = 128;     // matches that score a triple
constexpr double kWidth = 2;             // of the threshold
constexpr double kMinDifference = 0.01;  // rad: nearer poses are one

cv::Vec3d rayOf(const std::vector<float>& rays, std::size_t n, std::size_t i) {
  return {rays[i], rays[n + i], rays[2 * n + i]};
}

/// Solves A x = b. @return false where A has no inverse
bool solve(const cv::Matx33d& a, const cv::Vec3d& b, cv::Vec3d& x) {
  const double scale = cv::norm(a), determinant = cv::determinant(a);
  if (!(std::abs(determinant) > 1e-9 * scale * scale * scale)) return false;
  x = a.inv() * b;
  return true;
}

/// Difference of two poses, rad, apart from the sign of t, which a plane in front of one camera and behind
/// the other one leaves open.
double difference(const Pose& a, const Pose& b) {
  const double t = std::min(cv::norm(a.translation - b.translation), cv::norm(a.translation + b.translation));
  return std::max(cv::norm(a.rotation - b.rotation), t);
}

}  // namespace

bool PlaneFit::find(const Pose& pose, const RayTransfer& transfer, const std::vector<std::uint32_t>& rows,
                    double threshold, std::uint64_t seed, cv::Vec3d& normal) {
  measure(pose, transfer, rows);
  if (size_ < 3 || !drawTriples(kWidth * threshold, seed, normal)) return false;
  for (int round = 0; round < kRounds; ++round) refine(kWidth * threshold, normal);
  return true;
}

/// Computes the inverse depths and their weights.
void PlaneFit::measure(const Pose& pose, const RayTransfer& transfer,
                       const std::vector<std::uint32_t>& rows) {
  const RayColumns& rays = transfer.columns();
  const cv::Vec3d& t = pose.translation;
  size_ = rows.size();
  columns_.resize(5 * size_);
  for (std::size_t k = 0; k < size_; ++k) {
    const cv::Vec3d left = rayOf(rays.left, rays.size, rows[k]), b = rayOf(rays.right, rays.size, rows[k]);
    const cv::Vec3d a = pose.rotation * left, across = a.cross(b);
    const double depth = a.dot(b) * b.dot(t) - a.dot(t);
    const double mu = depth != 0 ? across.dot(across) / depth : 0;
    const cv::Vec3d p = a + t * mu, sideways = t.cross(p);
    const double length = p.dot(p), s1 = transfer.leftAngle(rows[k]), s2 = transfer.rightAngle(rows[k]);
    const double weight = std::sqrt(sideways.dot(sideways) / (length * (s1 * s1 + s2 * s2 * length)));
    const double values[5] = {left[0], left[1], left[2], mu, weight};
    for (std::size_t c = 0; c < 5; ++c) columns_[c * size_ + k] = static_cast<float>(values[c]);
  }
}

bool PlaneFit::drawTriples(double threshold, std::uint64_t seed, cv::Vec3d& normal) {
  const float *const x = columns_.data(), *const y = x + size_, *const z = y + size_, *const mu = z + size_,
                     *const weight = mu + size_;
  const std::size_t scored = std::min(size_, kScored);
  const auto limit = static_cast<float>(threshold);
  Random random(seed);
  int best = 0;
  for (int triple = 0; triple < kTriples; ++triple) {
    std::uint32_t sample[3];
    random.sample(static_cast<std::uint32_t>(size_), 3, sample);
    cv::Matx33d rows;
    cv::Vec3d depths, candidate;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = sample[k];
      rows(k, 0) = x[i], rows(k, 1) = y[i], rows(k, 2) = z[i], depths[k] = mu[i];
    }
    if (!solve(rows, depths, candidate)) continue;
    const float a = static_cast<float>(candidate[0]), b = static_cast<float>(candidate[1]),
                c = static_cast<float>(candidate[2]);
    int agreeing = 0;
    for (std::size_t i = 0; i < scored; ++i)
      agreeing += std::abs(a * x[i] + b * y[i] + c * z[i] - mu[i]) * weight[i] <= limit ? 1 : 0;
    if (agreeing <= best) continue;
    best = agreeing;
    normal = candidate;
  }
  return best > 0;
}

/// Least squares over the matches that agree with the plane.
void PlaneFit::refine(double threshold, cv::Vec3d& normal) const {
  cv::Matx33d a = cv::Matx33d::zeros();
  cv::Vec3d b;
  for (std::size_t i = 0; i < size_; ++i) {
    const cv::Vec3d d = rayOf(columns_, size_, i);
    const double mu = columns_[3 * size_ + i], weight = columns_[4 * size_ + i];
    if (!(std::abs(normal.dot(d) - mu) * weight <= threshold)) continue;
    const cv::Vec3d weighted = d * (weight * weight);
    a += weighted * d.t();
    b += weighted * mu;
  }
  cv::Vec3d fitted;
  if (solve(a, b, fitted)) normal = fitted;
}

cv::Matx33d homographyOf(const Pose& pose, const cv::Vec3d& normal) {
  return pose.rotation + pose.translation * normal.t();
}

std::optional<Pose> otherPoseOfPlane(const Pose& pose, const cv::Vec3d& normal, const RayMatches& matches,
                                     double threshold) {
  PlanePose poses[2];
  if (!posesOfPlane(homographyOf(pose, normal), matches, poses)) return std::nullopt;
  const bool first_is_known = difference(poses[0].pose, pose) < difference(poses[1].pose, pose);
  Pose other = poses[first_is_known ? 1 : 0].pose;
  fitPose(matches, threshold, kSteps, other);
  if (difference(other, pose) < kMinDifference) return std::nullopt;
  return other;
}

}  // namespace corrsel::core
