#include "calibrated/verdict.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/essential.h"
#include "geometry/known_motion.h"
#include "geometry/pose_fit.h"
#include "geometry/residual.h"
#include "posterior/noise_scale.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 8;       // five matches always agree with a pose of theirs
constexpr std::size_t kMinRepaired = 10000;  // re-paired matches that are drawn at least
constexpr double kMinChance = 1e-3;
constexpr int kPoseParameters = 5, kRotationParameters = 3, kHomographyParameters = 8;
constexpr double kRotationWidth = 1.5, kFarWidth = 3, kNearWidth = 2.5;  // of the unit
constexpr double kRotationDecades = 8, kPoseDecades = 9, kFarDecades = 12;
constexpr double kMinRatio = 1.3, kMinDeviations = 5;
constexpr double kMinOwnDeviations = 7, kMinShared = 1 / 9.;  // of the gains themselves
constexpr double kNoiseCut = 5;  // of the threshold: larger errors do not count for the noise
constexpr double kUnitPerNoise = 4 / 3.;
constexpr double kMinVariance = 1e-4;    // px^2, what rounding leaves
constexpr double kRestDisplacement = 1;  // of the unit
constexpr double kRestSquares = 36;      // of three components in units of their variance
constexpr double kMinInFront = 0.95;     // of the matches that the other pose of a plane has in front
constexpr std::size_t kMaxFitted = 512;  // matches to which planes and their poses are fitted
constexpr double kMinExtent = 3;         // of the threshold: matches within it are one place

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

/// The least number that a Poisson variable exceeds with a probability below 1e-4.
std::size_t countOfChance(double mean) {
  double term = std::exp(-mean), sum = term;
  std::size_t count = 0;
  while (1 - sum > 1e-4 && term > 0) {
    ++count;
    term *= mean / static_cast<double>(count);
    sum += term;
  }
  return count;
}

double shareOf(std::size_t count, std::size_t drawn) {
  return std::max(kMinChance, static_cast<double>(count) / static_cast<double>(drawn));
}

}  // namespace

Verdict MotionVerdict::decide(const VerdictInput& input) {
  Verdict verdict;
  if (input.matches.size() < kMinMatches) return verdict;
  transfer_.assign(input.columns);
  parameters_ = freedomOf(input.prior).size;
  measurePose(input);
  measureNoise(input);
  const cv::Matx33d rotation = constrained(
      input.prior, rotations_.find(transfer_, input.best_first, input.pose ? &input.pose->rotation : nullptr,
                                   kRotationWidth * unit_, input.seed));
  measureRotation(input, rotation);
  const bool rotates = isReal(input, rotated_, 2, rotation_chance_, kRotationDecades) ||
                       isReal(input, near_rotation_, 2, near_rotation_chance_, kRotationDecades);
  const bool posed = isReal(input, posed_, static_cast<std::size_t>(parameters_), pose_chance_, kPoseDecades);
  if (posed && (!rotates || translates(input, rotation_errors_, kRotationParameters))) {
    verdict.motion = Motion::kGeneral;
    verdict.pose = *input.pose;
    verdict.rotation = rotation;
    decidePlane(input, verdict);
    verdict.parallax = parallax(verdict.pose.rotation, posed_);
  } else if (rotates) {
    if (rotated_.size() < kMinMatches) rotated_ = near_rotation_;
    const bool rests = isAtRest(input, rotation);
    verdict.motion = rests ? Motion::kRest : Motion::kRotation;
    if (!rests || input.prior) verdict.rotation = rotation;
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

/// Estimates the noise of the pose's errors, and the unit of all widths.
void MotionVerdict::measureNoise(const VerdictInput& input) {
  noise_ = 0;
  if (input.pose) {
    ResidualKind kind;
    kind.dimensions = 1;
    kind.parameters = parameters_;
    kind.cut = kNoiseCut * input.threshold;
    kind.background = pose_chance_ * static_cast<double>(input.matches.size()) / input.threshold;
    wide_errors_.assign(pose_errors_.begin(), pose_errors_.end());
    const double sigma = estimateNoiseScale(wide_errors_, kind).sigma;
    if (sigma > 0) noise_ = sigma;
  }
  unit_ = std::max(input.threshold, kUnitPerNoise * noise_);
}

/// The same for the rotation, in two widths.
void MotionVerdict::measureRotation(const VerdictInput& input, const cv::Matx33d& rotation) {
  const std::size_t n = input.matches.size();
  rotation_errors_.resize(n);
  transfer_.rotationErrors(rotation, n, rotation_errors_.data());
  const double limit = squared(kRotationWidth * unit_), wide = squared(kFarWidth * unit_);
  collect(rotation_errors_, limit, rotated_);
  collect(rotation_errors_, wide, near_rotation_);
  std::size_t count = 0, wide_count = 0;
  const std::size_t drawn = forRepaired(
      n, errors_, [&](std::size_t shift, float* out) { transfer_.repairedErrors(rotation, shift, out); },
      [&](std::size_t, std::size_t, float error) {
        count += error <= static_cast<float>(limit) ? 1 : 0;
        wide_count += error <= static_cast<float>(wide) ? 1 : 0;
      });
  rotation_chance_ = shareOf(count, drawn);
  near_rotation_chance_ = shareOf(wide_count, drawn);
  near_chance_ = static_cast<double>(wide_count + 1) / static_cast<double>(drawn);
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
/// @param parameters  of that model where nothing is known of the motion; a prior fixes as many of the pose
bool MotionVerdict::translates(const VerdictInput& input, const std::vector<float>& errors, int parameters) {
  const auto far_limit = static_cast<float>(squared(kFarWidth * unit_));
  const auto near_limit = static_cast<float>(squared(kNearWidth * unit_));
  const bool from_rotation = parameters == kRotationParameters;
  std::size_t far = 0, far_agreeing = 0;
  double by_chance = 0;
  near_.clear();
  for (std::uint32_t i = 0; i < errors.size(); ++i) {
    if (!(errors[i] <= far_limit)) {
      ++far;
      far_agreeing += agrees_[i];
      by_chance += from_rotation ? chanceOfDisplaced(input, errors[i]) : pose_chance_;
    } else if (pose_errors_[i] <= near_limit) {
      near_.push_back(i);
    }
  }
  const double mean_chance = far > 0 ? by_chance / static_cast<double>(far) : pose_chance_;
  if (-log10BinomialTail(far, far_agreeing, mean_chance) > kFarDecades) return true;
  const std::size_t dropped = std::min(near_.size(), countOfChance(static_cast<double>(far) * near_chance_));
  const auto gains_more = [&](std::uint32_t a, std::uint32_t b) {
    return errors[a] - pose_errors_[a] > errors[b] - pose_errors_[b];
  };
  const auto kept = near_.begin() + static_cast<std::ptrdiff_t>(dropped);
  std::nth_element(near_.begin(), kept, near_.end(), gains_more);
  double simple_sum = 0, pose_sum = 0;
  for (auto row = kept; row != near_.end(); ++row) {
    simple_sum += static_cast<double>(errors[*row]);
    pose_sum += static_cast<double>(pose_errors_[*row]);
  }
  const auto count = static_cast<double>(near_.size() - dropped);
  const double freedom = count - parameters_, gained = count + kPoseParameters - parameters;
  if (!(freedom > 0 && gained > 0)) return false;
  const double variance = std::max(kMinVariance, pose_sum / freedom);
  const double ratio = (simple_sum - pose_sum) / gained / variance;
  return ratio > kMinRatio && std::log(ratio) > kMinDeviations * std::sqrt(2 / gained + 2 / freedom) &&
         (!from_rotation || isShared(kept, errors));
}

/// The chance that a match agrees with the pose and lies in front whose feature was found at another place
/// nearby: in any direction from the place that the rotation explains. It is larger than that of wrong
/// matches, which are anywhere in the image.
/// @param error  of the rotation, squared, px^2, beyond kFarWidth
double MotionVerdict::chanceOfDisplaced(const VerdictInput& input, float error) const {
  const double sine = input.threshold / std::sqrt(static_cast<double>(error));
  return std::isfinite(error) ? std::max(pose_chance_, std::asin(std::min(1.0, sine)) / CV_PI) : pose_chance_;
}

/// Whether the displacements from the rotation along the epipolar lines exceed those across for the matches
/// in common, and not only for a few whose error is large: the sum of the differences of the squares, which
/// is 0 in the mean without a translation, in units of the root of the sum of their squares. This holds for
/// noise of any distribution; the pose, however, is the one that aligns the largest errors.
bool MotionVerdict::isShared(std::vector<std::uint32_t>::const_iterator first,
                             const std::vector<float>& errors) const {
  double sum = 0, squares = 0;
  for (auto row = first; row != near_.end(); ++row) {
    const double difference = static_cast<double>(errors[*row]) - 2 * static_cast<double>(pose_errors_[*row]);
    sum += difference;
    squares += squared(difference);
  }
  const auto count = static_cast<double>(near_.end() - first);
  return sum > 0 && squared(sum) > std::min(squared(kMinOwnDeviations), kMinShared * count) * squares;
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
  const double variance =
      std::max({kMinVariance, squared(noise_), errors / (2 * count - kRotationParameters)});
  return 2 * moved / count < squared(kRestDisplacement * unit_) || moved < kRestSquares * variance;
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
  rows_.assign(posed_.begin(),
               posed_.begin() + static_cast<std::ptrdiff_t>(std::min(posed_.size(), kMaxFitted)));
  if (!plane_.find(verdict.pose, transfer_, rows_, unit_, input.seed, normal)) return;
  errors_.resize(transfer_.size());
  transfer_.homographyErrors(homographyOf(verdict.pose, normal), errors_.data());
  if (translates(input, errors_, kHomographyParameters)) return;
  verdict.motion = Motion::kPlanar;
  if (input.prior) return;
  collect(errors_, squared(kFarWidth * unit_), rows_);
  if (rows_.size() > kMaxFitted) rows_.resize(kMaxFitted);
  gatherRays(input.matches, rows_, fitted_);
  const std::optional<Pose> other = otherPoseOfPlane(verdict.pose, normal, fitted_, unit_);
  if (other) choosePose(*other, verdict);
}

/// Reports the better one of two poses, and the other one where the matches do not exclude it.
void MotionVerdict::choosePose(const Pose& other, Verdict& verdict) {
  const Pose poses[2] = {verdict.pose, other};
  double cost[2], in_front[2];
  for (int k = 0; k < 2; ++k) {
    cost[k] = poseSums(poses[k], fitted_, unit_).cost;
    in_front[k] = 0;
    for (std::size_t i = 0; i < fitted_.size(); ++i)
      in_front[k] += core::isInFront(poses[k], fitted_, i, unit_) ? 1 : 0;
  }
  const double needed = kMinInFront * std::max(in_front[0], in_front[1]);
  const bool is_visible[2] = {in_front[0] >= needed, in_front[1] >= needed};
  const int best = is_visible[0] != is_visible[1] ? (is_visible[0] ? 0 : 1) : (cost[0] <= cost[1] ? 0 : 1);
  verdict.pose = poses[best];
  const auto count = static_cast<double>(fitted_.size());
  const double limit = (1 + 3 / std::sqrt(count)) * std::max(cost[best], kMinVariance * count);
  if (is_visible[1 - best] && cost[1 - best] < limit) verdict.second = poses[1 - best];
}

}  // namespace corrsel::core
