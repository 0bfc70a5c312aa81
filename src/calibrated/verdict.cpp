#include "calibrated/verdict.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/essential.h"
#include "geometry/pose_fit.h"
#include "geometry/residual.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 8;       // five matches always agree with a pose of theirs
constexpr std::size_t kMinRepaired = 10000;  // re-paired matches that are drawn at least
constexpr double kMinChance = 1e-3;
constexpr int kPoseParameters = 5, kRotationParameters = 3, kHomographyParameters = 8;
constexpr double kRotationWidth = 1.5, kFarWidth = 3, kNearWidth = 2.5;  // of the threshold
constexpr double kRotationDecades = 8, kPoseDecades = 9, kFarDecades = 9;
constexpr double kMinRatio = 1.3, kMinDeviations = 5;
constexpr double kMinVariance = 1e-4;  // px^2, what rounding leaves
constexpr double kRestDisplacement = 0.3;
constexpr double kRestSquares = 25;  // of three components in units of their variance
constexpr double kMinInFront = 0.8;
constexpr double kMinExtent = 3;  // of the threshold: matches within it are one place

double squared(double value) { return value * value; }

/// Rows whose error is at most the limit.
void collect(const std::vector<float>& errors, double limit, std::vector<std::uint32_t>& rows) {
  rows.clear();
  for (std::uint32_t i = 0; i < errors.size(); ++i)
    if (errors[i] <= static_cast<float>(limit)) rows.push_back(i);
}

/// Root mean square distance of rays from their mean over the root mean square pixel angle, px.
double extent(const std::vector<float>& rays, std::size_t n, const std::vector<std::uint32_t>& rows) {
  double sums[3] = {}, angles = 0;
  for (const std::uint32_t i : rows) {
    for (std::size_t k = 0; k < 3; ++k) sums[k] += static_cast<double>(rays[k * n + i]);
    for (std::size_t k = 3; k < kRayNumbers; ++k)
      angles += 0.5 * squared(static_cast<double>(rays[k * n + i]));
  }
  const auto count = static_cast<double>(rows.size());
  const double mean = (squared(sums[0]) + squared(sums[1]) + squared(sums[2])) / count;
  return std::sqrt(std::max(0.0, count - mean) / angles);
}

/// Calls use(left, right, error) for re-paired matches, at least kMinRepaired if there are so many.
/// @param errors  writes the errors of all left rays with the right rays `shift` further
/// @return how many were drawn
template <typename Errors, typename Use>
std::size_t forRepaired(std::size_t n, std::vector<float>& memory, const Errors& errors, const Use& use) {
  std::size_t drawn = 0;
  memory.resize(n);
  for (std::size_t shift = 1; shift < n && drawn < kMinRepaired; ++shift, drawn += n) {
    errors(shift, memory.data());
    for (std::size_t i = 0; i < n; ++i) use(i, i + shift < n ? i + shift : i + shift - n, memory[i]);
  }
  return drawn;
}

double shareOf(std::size_t count, std::size_t drawn) {
  return std::max(kMinChance, static_cast<double>(count) / static_cast<double>(drawn));
}

}  // namespace

Verdict MotionVerdict::decide(const VerdictInput& input) {
  Verdict verdict;
  if (input.matches.size() < kMinMatches) return verdict;
  transfer_.assign(input.columns);
  measurePose(input);
  const cv::Matx33d rotation =
      rotations_.find(transfer_, input.best_first, input.pose ? &input.pose->rotation : nullptr,
                      kRotationWidth * input.threshold, input.seed);
  measureRotation(input, rotation);
  const bool rotates = isReal(input, rotated_, 2, rotation_chance_, kRotationDecades);
  const bool posed = isReal(input, posed_, 5, pose_chance_, kPoseDecades);
  if (posed && (!rotates || translates(input, rotation_errors_, kRotationParameters))) {
    verdict.motion = Motion::kGeneral;
    verdict.pose = *input.pose;
    verdict.rotation = rotation;
    decidePlane(input, verdict);
    verdict.parallax = parallax(verdict.pose.rotation, posed_);
  } else if (rotates) {
    const bool rests = isAtRest(input, rotation);
    verdict.motion = rests ? Motion::kRest : Motion::kRotation;
    if (!rests) verdict.rotation = rotation;
    verdict.parallax = parallax(verdict.rotation, rotated_);
  }
  return verdict;
}

/// Computes the errors under the pose, the matches that agree, and how often they do by chance.
void MotionVerdict::measurePose(const VerdictInput& input) {
  const std::size_t n = input.matches.size();
  posed_.clear();
  agrees_.assign(n, 0);
  if (!input.pose) return;
  const cv::Matx33d essential = essentialOf(*input.pose);
  const auto limit = static_cast<float>(squared(input.threshold));
  pose_errors_.resize(n);
  repairedErrors(essential, input.columns, 0, pose_errors_.data());
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!(pose_errors_[i] <= limit) || !isInFront(input, i, i)) continue;
    agrees_[i] = 1;
    posed_.push_back(i);
  }
  std::size_t count = 0;
  const std::size_t drawn = forRepaired(
      n, errors_,
      [&](std::size_t shift, float* out) { repairedErrors(essential, input.columns, shift, out); },
      [&](std::size_t left, std::size_t right, float error) {
        if (error <= limit && isInFront(input, left, right)) ++count;
      });
  pose_chance_ = shareOf(count, drawn);
}

/// The same for the rotation.
void MotionVerdict::measureRotation(const VerdictInput& input, const cv::Matx33d& rotation) {
  const std::size_t n = input.matches.size();
  const double limit = squared(kRotationWidth * input.threshold);
  rotation_errors_.resize(n);
  transfer_.rotationErrors(rotation, n, rotation_errors_.data());
  collect(rotation_errors_, limit, rotated_);
  std::size_t count = 0;
  const std::size_t drawn = forRepaired(
      n, errors_, [&](std::size_t shift, float* out) { transfer_.repairedErrors(rotation, shift, out); },
      [&](std::size_t, std::size_t, float error) { count += error <= static_cast<float>(limit) ? 1 : 0; });
  rotation_chance_ = shareOf(count, drawn);
}

/// Whether a left and a right ray meet in front of both cameras, see isInFront() of geometry/essential.h.
bool MotionVerdict::isInFront(const VerdictInput& input, std::size_t left, std::size_t right) const {
  const ScaledDepths depths =
      scaledDepths(*input.pose, input.matches.left.direction(left), input.matches.right.direction(right));
  const double limit =
      -input.threshold * static_cast<double>(transfer_.leftAngle(left) + transfer_.rightAngle(right));
  return depths.left > limit && depths.right > limit;
}

/// Whether a model that the matches were chosen for is more than chance.
bool MotionVerdict::isReal(const VerdictInput& input, const std::vector<std::uint32_t>& agreeing,
                           std::size_t sample_size, double chance, double decades) const {
  const std::size_t n = input.matches.size();
  if (agreeing.size() < kMinMatches) return false;
  if (-log10BinomialTail(n - sample_size, agreeing.size() - sample_size, chance) <= decades) return false;
  const double limit = kMinExtent * input.threshold;
  return extent(input.columns.left, n, agreeing) > limit && extent(input.columns.right, n, agreeing) > limit;
}

/// Whether the pose explains more than a simpler model does.
/// @param errors      of that model
/// @param parameters  of that model
bool MotionVerdict::translates(const VerdictInput& input, const std::vector<float>& errors,
                               int parameters) const {
  const auto far_limit = static_cast<float>(squared(kFarWidth * input.threshold));
  const auto near_limit = static_cast<float>(squared(kNearWidth * input.threshold));
  std::size_t far = 0, far_agreeing = 0, near = 0;
  double simple_sum = 0, pose_sum = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!(errors[i] <= far_limit)) {
      ++far;
      far_agreeing += agrees_[i];
    } else if (pose_errors_[i] <= near_limit) {
      ++near;
      simple_sum += static_cast<double>(errors[i]);
      pose_sum += static_cast<double>(pose_errors_[i]);
    }
  }
  if (-log10BinomialTail(far, far_agreeing, pose_chance_) > kFarDecades) return true;
  const double freedom = static_cast<double>(near) - kPoseParameters;
  const double gained = static_cast<double>(near) + kPoseParameters - parameters;
  if (!(freedom > 0 && gained > 0)) return false;
  const double variance = std::max(kMinVariance, pose_sum / freedom);
  const double ratio = (simple_sum - pose_sum) / gained / variance;
  return ratio > kMinRatio && ratio - 1 > kMinDeviations * std::sqrt(2 / gained + 2 / freedom);
}

/// Whether the rotation moves the points by no more than its own uncertainty.
bool MotionVerdict::isAtRest(const VerdictInput& input, const cv::Matx33d& rotation) const {
  double moved = 0, errors = 0;
  for (const std::uint32_t i : rotated_) {
    const cv::Vec3d left = input.matches.left.direction(i), difference = rotation * left - left;
    moved += difference.dot(difference) * static_cast<double>(transfer_.weight(i));
    errors += static_cast<double>(rotation_errors_[i]);
  }
  const auto count = static_cast<double>(rotated_.size());
  const double variance = std::max(kMinVariance, errors / (2 * count - kRotationParameters));
  return 2 * moved / count < squared(kRestDisplacement) || moved < kRestSquares * variance;
}

/// Root mean square displacement of the matches from the rotation, px.
double MotionVerdict::parallax(const cv::Matx33d& rotation, const std::vector<std::uint32_t>& rows) {
  errors_.resize(transfer_.size());
  transfer_.rotationErrors(rotation, transfer_.size(), errors_.data());
  double sum = 0;
  for (const std::uint32_t i : rows) sum += static_cast<double>(errors_[i]);
  return std::sqrt(2 * sum / static_cast<double>(rows.size()));
}

/// Makes a general motion a planar one where the matches show no depth.
void MotionVerdict::decidePlane(const VerdictInput& input, Verdict& verdict) {
  cv::Vec3d normal;
  if (!plane_.find(verdict.pose, transfer_, posed_, input.threshold, input.seed, normal)) return;
  errors_.resize(transfer_.size());
  transfer_.homographyErrors(homographyOf(verdict.pose, normal), errors_.data());
  if (translates(input, errors_, kHomographyParameters)) return;
  verdict.motion = Motion::kPlanar;
  gatherRays(input.matches, posed_, fitted_);
  const std::optional<Pose> other = otherPoseOfPlane(verdict.pose, normal, fitted_, input.threshold);
  if (other) choosePose(input, *other, verdict);
}

/// Reports the better one of two poses, and the other one where the matches do not exclude it.
void MotionVerdict::choosePose(const VerdictInput& input, const Pose& other, Verdict& verdict) {
  const auto count = static_cast<double>(fitted_.size());
  const double cost = poseSums(verdict.pose, fitted_, input.threshold).cost;
  const double other_cost = poseSums(other, fitted_, input.threshold).cost;
  std::size_t in_front = 0;
  for (std::size_t i = 0; i < fitted_.size(); ++i)
    in_front += core::isInFront(other, fitted_, i, input.threshold) ? 1 : 0;
  if (static_cast<double>(in_front) < kMinInFront * count) return;
  const double factor = 1 + 3 / std::sqrt(count);
  if (other_cost < factor * cost) verdict.second = other;
  if (other_cost < cost) {
    verdict.second = verdict.pose;
    verdict.pose = other;
    if (cost >= factor * other_cost) verdict.second.reset();
  }
}

}  // namespace corrsel::core
