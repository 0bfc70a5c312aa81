#include "calibrated/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>  // inv()

#include "base/gather.h"
#include "calibrated/guess_search.h"
#include "geometry/essential.h"
#include "geometry/known_motion.h"
#include "geometry/rotation.h"
#include "posterior/noise_scale.h"
#include "search/essential_model.h"
#include "search/prior_models.h"
#include "search/prosac_proposal.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinAgreeing = 8;  // five matches always agree with themselves
constexpr double kMaxChance = 0.02;      // share of chance agreements up to which the covariance holds
constexpr double kChanceWithoutSupport = 0.001;  // share above which local support is asked for
constexpr std::size_t kMinSupported = 20;
constexpr std::size_t kFewAgreeing = 250;  // below it, a second search begins with local support
constexpr double kNoiseCut = 2.5;          // times the threshold: larger residuals do not count for the noise

/// The model by which samples are solved: that of the prior, which is not of a rig.
const Model& modelFor(const std::optional<PosePrior>& prior, Workspace& workspace) {
  if (!prior) return workspace.part<EssentialModel>();
  if (prior->kind == PosePrior::Kind::kRotation) {
    KnownRotationModel& model = workspace.part<KnownRotationModel>();
    model.setPrior(*prior);
    return model;
  }
  KnownVerticalModel& model = workspace.part<KnownVerticalModel>();
  model.setPrior(*prior);
  return model;
}

/// The inverse of the information about a rotation in the directions that are free; 0 in the others.
cv::Matx33d inverseOf(const cv::Matx33d& information, const PoseFreedom& freedom) {
  if (freedom.size == PoseFreedom::all().size) return information.inv();
  cv::Matx33d result = cv::Matx33d::zeros();
  for (int k = 0; k < freedom.size; ++k) {  // one of them at most turns
    const cv::Vec3d axis(freedom.directions[k].val);
    const double known = axis.dot(information * axis);
    if (known > 0) result += axis * axis.t() * (1 / known);
  }
  return result;
}

/// Covariance of a rotation (first three rows and columns) from the matches that agree with it.
cv::Matx<double, 5, 5> rotationCovariance(const cv::Matx33d& rotation, const RayMatches& matches,
                                          const PoseFreedom& pose_freedom, double threshold, double& noise) {
  PoseResult undefined;  // whose covariance is NaN
  cv::Matx33d information = cv::Matx33d::zeros();
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const double squared = squaredRotationError(rotation, matches, i);
    if (!(squared <= threshold * threshold)) continue;
    const double left = matches.left.pixelAngle(i), right = matches.right.pixelAngle(i);
    const cv::Vec3d d = rotation * matches.left.direction(i);
    information += (cv::Matx33d::eye() - d * d.t()) * (1 / (left * left + right * right));
    squares += squared;
    ++count;
  }
  const int parameters = pose_freedom.size - PoseFreedom::translation().size;
  const double freedom = 2.0 * static_cast<double>(count) - parameters;
  if (!(freedom > 0)) return undefined.covariance;
  noise = std::sqrt(squares / freedom);
  const cv::Matx33d covariance = inverseOf(information, pose_freedom) * (noise * noise);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) undefined.covariance(row, column) = covariance(row, column);
  return undefined.covariance;
}

/// Whether the rays of an image lie in a plane, but for `tolerance` px: all points on one line.
bool isOnLine(const Rays& rays, const std::vector<std::uint32_t>& rows, double tolerance) {
  cv::Matx33d scatter = cv::Matx33d::zeros();
  for (const std::uint32_t i : rows) {
    const cv::Vec3d d = rays.direction(i) * (1 / rays.pixelAngle(i));
    scatter += d * d.t();
  }
  cv::Vec3d values;  // descending
  cv::eigen(scatter, values);
  return values[2] <= static_cast<double>(rows.size()) * tolerance * tolerance;
}

void fail(Selection& result, Status status, const std::string& message) {
  result.status = status;
  addRemark(result, message);
}

}  // namespace

/// Noise of the agreeing matches, px.
double PoseSearch::noise(double threshold) const {
  ResidualKind kind;
  kind.dimensions = 1;
  kind.parameters = freedom_.size;
  kind.cut = kNoiseCut * threshold;
  kind.background = refinement_.chance().share() * static_cast<double>(set_.size()) / threshold;
  return estimateNoiseScale(refinement_.errors(), kind).sigma;
}

/// Refines the pose, by matches with local support where agreements by chance matter. Where the threshold
/// follows the noise, twice more.
bool PoseSearch::refine(const Correspondences& matches, const PoseParameters& parameters, Pose& pose) {
  constexpr double kThresholdPerNoise = 2.5, kMin = 0.2, kMax = 3;  // of the user's threshold
  const RayColumns& columns = input_.matches.rays;
  const std::vector<std::uint8_t>* candidates = nullptr;
  double threshold = parameters.threshold;
  const auto again = [&] {
    return refinement_.refine(set_, columns, threshold, parameters.covariance, candidates, freedom_, pose);
  };
  if (!again()) return false;
  if (parameters.covariance && chanceShare() > kChanceWithoutSupport &&
      isSupported(supported(matches, parameters.supported))) {
    candidates = &candidates_;
    if (!again()) return false;
  }
  for (int round = 0; parameters.adaptive && round < 2; ++round) {
    const double sigma = noise(threshold);
    if (std::isnan(sigma)) break;
    threshold =
        std::clamp(kThresholdPerNoise * sigma, kMin * parameters.threshold, kMax * parameters.threshold);
    if (!again()) return false;
  }
  fitted_threshold_ = threshold;
  return true;
}

/// Share of the fitted matches that are expected to agree by chance.
double PoseSearch::chanceShare() const {
  const auto fitted = static_cast<double>(refinement_.fitted().size());
  return refinement_.chance().expectedAmongCounting() / std::max(1.0, fitted);
}

/// Finds out which matches of the search set have local support.
const std::vector<std::uint8_t>& PoseSearch::supported(const Correspondences& matches,
                                                       const std::vector<std::uint8_t>* known) {
  if (support_known_) return candidates_;
  support_known_ = true;
  if (known != nullptr) {
    gather(*known, search_set_.rows(), candidates_);
    return candidates_;
  }
  gather(matches, search_set_.rows(), supported_);
  support_.compute(supported_, order());
  candidates_ = support_.extended();
  return candidates_;
}

/// The search set by quality; where that is unknown, in random order.
std::vector<std::uint32_t> PoseSearch::order() const {
  if (input_.best_first != nullptr) return *input_.best_first;
  std::vector<std::uint32_t> result(set_.size());
  std::iota(result.begin(), result.end(), 0U);
  return result;
}

/// Whether enough of the agreeing matches have local support.
bool PoseSearch::isSupported(const std::vector<std::uint8_t>& supported) const {
  std::size_t count = 0;
  for (const std::uint32_t i : refinement_.agreeing()) count += supported[i];
  return count >= kMinSupported;
}

/// Searches by quality. Where few matches agree, a second search begins with those that have local support,
/// and the better model remains.
SearchOutcome PoseSearch::search(const Correspondences& matches, const PoseParameters& parameters,
                                 const SearchParts& parts, const Deadline& deadline, Workspace& workspace) {
  SearchOutcome first =
      core::search(input_.matches, parts, parameters.search, input_.best_first, deadline, workspace);
  if (!parameters.covariance || first.timed_out || first.best.inliers >= kFewAgreeing) return first;
  const std::vector<std::uint8_t>& supports = supported(matches, parameters.supported);
  std::vector<std::uint32_t> by_support = order();
  std::stable_partition(by_support.begin(), by_support.end(),
                        [&](std::uint32_t i) { return supports[i] != 0; });
  SearchOutcome second =
      core::search(input_.matches, parts, parameters.search, &by_support, deadline, workspace);
  second.iterations += first.iterations;
  if (first.best.cost <= second.best.cost) second.best = first.best;
  return second;
}

/// Fills the answer by the verdict.
void PoseSearch::describe(const PoseParameters& parameters, const Verdict& verdict, PoseResult& found) const {
  found.motion = verdict.motion;
  found.parallax = verdict.parallax;
  if (verdict.motion == Motion::kGeneral || verdict.motion == Motion::kPlanar) {
    found.pose = verdict.pose;
    found.second = verdict.second;
    found.noise = noise(fitted_threshold_);
    found.uncertain = chanceShare() > kMaxChance;
    if (parameters.covariance && !found.uncertain)
      poseCovariance(found.pose, refinement_.fitted(), fitted_threshold_, found.covariance, freedom_);
  } else if (verdict.motion != Motion::kNone) {
    found.pose.rotation = verdict.rotation;
    const cv::Matx<double, 5, 5> covariance = rotationCovariance(
        verdict.rotation, set_, freedom_, kRotationWidth * parameters.threshold, found.noise);
    if (parameters.covariance) found.covariance = covariance;
  }
}

/// Root mean square displacement from the rotation of the matches that agree with the refined pose, px; NaN
/// without any.
double PoseSearch::parallax(const Pose& pose, double threshold) const {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < set_.size(); ++i) {
    if (!(refinement_.errors()[i] <= threshold * threshold) || !isInFront(pose, set_, i, threshold)) continue;
    sum += squaredRotationError(pose.rotation, set_, i);
    ++count;
  }
  return std::sqrt(2 * sum / count);
}

/// Measures the matches by the known pose.
PoseResult PoseSearch::judgeRig(const PoseParameters& parameters) {
  PoseResult found;
  found.motion = Motion::kGeneral;
  found.pose = {parameters.prior->rotation, parameters.prior->translation};
  found.covariance = cv::Matx<double, 5, 5>::zeros();
  Pose pose = found.pose;
  const double threshold = parameters.threshold;
  if (refinement_.refine(set_, input_.matches.rays, threshold, true, nullptr, freedom_, pose))
    found.noise = noise(threshold);
  found.parallax = parallax(pose, threshold);
  return found;
}

/// Whether the matches that agree with the answer are on one line of an image. They have two mirrored poses
/// then, and a rotation cannot be told from a translation.
bool PoseSearch::isOnLine(const Verdict& verdict, double threshold) {
  if (freedom_.size < PoseFreedom::all().size) return false;  // a prior tells them apart
  if (verdict.motion == Motion::kGeneral || verdict.motion == Motion::kPlanar) {
    agreeing_ = refinement_.agreeing();
  } else {
    const double width = kRotationWidth * threshold;
    agreeing_.clear();
    for (std::uint32_t i = 0; i < set_.size(); ++i)
      if (squaredRotationError(verdict.rotation, set_, i) <= width * width) agreeing_.push_back(i);
  }
  return core::isOnLine(set_.left, agreeing_, threshold) || core::isOnLine(set_.right, agreeing_, threshold);
}

std::optional<PoseResult> PoseSearch::find(const Correspondences& matches, const PoseParameters& parameters,
                                           const Deadline& deadline, Workspace& workspace,
                                           Selection& result) {
  Proposal& proposal = workspace.part<ProsacProposal>();
  input_.readRays(matches, parameters.search.seed, result);
  const std::vector<std::uint32_t>& set = search_set_.choose(matches, input_.rows());
  const bool is_rig = parameters.prior && parameters.prior->kind == PosePrior::Kind::kRig;
  const Model* const model = is_rig ? nullptr : &modelFor(parameters.prior, workspace);
  if (model != nullptr && set.size() == 1 && input_.rows().size() > 1) {
    fail(result, Status::kDegenerate, "all matches share one point");
    return std::nullopt;
  }
  if (model != nullptr && !isEnough(set.size(), *model, result)) return std::nullopt;
  input_.takeWithRays(matches, set, proposal, result);
  gatherRays(input_.rays(), set, set_);
  freedom_ = freedomOf(parameters.prior);
  support_known_ = false;
  if (model == nullptr) return judgeRig(parameters);
  std::optional<PoseResult> found;
  if (parameters.guess && !parameters.prior)
    found = findByGuess(matches, parameters, proposal, deadline, workspace, result);
  if (!found) {
    found = answer(matches, parameters, search(matches, parameters, {*model, proposal}, deadline, workspace),
                   result);
  }
  if (parameters.guess && found) {
    result.guess =
        agreesWithGuess(*found, *parameters.guess) ? GuessVerdict::kConfirmed : GuessVerdict::kContradicted;
  }
  return found;
}

/// Searches from the hypothesis of the guess on. As two independent sources agree where it is the best one,
/// few samples are drawn.
/// @return nothing if the answer does not agree with the guess
std::optional<PoseResult> PoseSearch::findByGuess(const Correspondences& matches,
                                                  const PoseParameters& parameters, Proposal& proposal,
                                                  const Deadline& deadline, Workspace& workspace,
                                                  Selection& result) {
  constexpr double kConfidence = 0.95;
  constexpr int kMaxIterations = 2000;
  int iterations = 0;
  const std::optional<cv::Matx33d> hypothesis =
      hypothesisOfGuess(*parameters.guess, {input_.matches, set_, input_.best_first, proposal},
                        parameters.search, deadline, workspace, iterations);
  if (!hypothesis) return std::nullopt;
  SearchParameters few = parameters.search;
  few.confidence = std::min(few.confidence, kConfidence);
  few.max_iterations = few.max_iterations > 0 ? std::min(few.max_iterations, kMaxIterations) : kMaxIterations;
  SearchOutcome outcome =
      core::search(input_.matches, {workspace.part<EssentialModel>(), proposal, nullptr, &*hypothesis}, few,
                   input_.best_first, deadline, workspace);
  outcome.iterations += iterations;
  Selection attempt = result;
  const std::optional<PoseResult> found = answer(matches, parameters, outcome, attempt);
  if (!found || attempt.status != Status::kOk || !agreesWithGuess(*found, *parameters.guess))
    return std::nullopt;
  result = attempt;
  return found;
}

/// Makes an answer of what the search found.
std::optional<PoseResult> PoseSearch::answer(const Correspondences& matches, const PoseParameters& parameters,
                                             const SearchOutcome& outcome, Selection& result) {
  result.iterations = outcome.iterations;
  if (outcome.timed_out) reportEnd(outcome, parameters.max_seconds, result);
  Pose pose;
  const bool posed = outcome.best.exists() && outcome.best.inliers >= kMinAgreeing &&
                     choosePose(outcome.best.model, set_, parameters.threshold, pose, parameters.prior);
  const bool refined = posed && refine(matches, parameters, pose);
  Verdict verdict = verdict_.decide({set_, input_.matches.rays, input_.best_first, refined ? &pose : nullptr,
                                     parameters.threshold, parameters.search.seed, parameters.prior});
  if (verdict.motion == Motion::kNone) {
    fail(result, posed && !refined ? Status::kDegenerate : Status::kNoModel,
         posed && !refined ? "the matches do not determine a pose"
                           : "no motion of the camera explains more matches than chance");
    return std::nullopt;
  }
  if (isOnLine(verdict, parameters.threshold)) {
    fail(result, Status::kDegenerate, "the matches that agree are on one line of an image");
    return std::nullopt;
  }
  // The other pose of the plane may fit better than the one that was refined.
  if (verdict.motion == Motion::kPlanar) refine(matches, parameters, verdict.pose);
  PoseResult found;
  describe(parameters, verdict, found);
  return found;
}

}  // namespace corrsel::core
