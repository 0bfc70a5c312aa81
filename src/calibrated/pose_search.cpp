#include "calibrated/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>  // inv()

#include "base/gather.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"
#include "geometry/rotation.h"
#include "posterior/noise_scale.h"
#include "search/essential_model.h"
#include "search/prosac_proposal.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinAgreeing = 8;  // five matches always agree with themselves
constexpr double kMaxChance = 0.02;      // share of chance agreements up to which the covariance holds
constexpr double kChanceWithoutSupport = 0.001;  // share above which local support is asked for
constexpr std::size_t kMinSupported = 20;
constexpr double kNoiseCut = 2.5;       // times the threshold: larger residuals do not count for the noise
constexpr double kRotationWidth = 1.5;  // of the threshold
constexpr int kEssentialParameters = 5, kRotationParameters = 3;

/// Covariance of a rotation (first three rows and columns) from the matches that agree with it.
cv::Matx<double, 5, 5> rotationCovariance(const cv::Matx33d& rotation, const RayMatches& matches,
                                          double threshold, double& noise) {
  PoseResult undefined;
  cv::Matx33d information = cv::Matx33d::zeros();
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const double squared = squaredRotationError(rotation, matches, i);
    if (!(squared <= threshold * threshold)) continue;
    const double left = matches.left.pixelAngle(i), right = matches.right.pixelAngle(i);
    const cv::Vec3d d = rotation * matches.left.direction(i);
    information += (cv::Matx33d::eye() - d * d.t()) * (1 / (left * left + right * right));
    squares += squared / 2;
    ++count;
  }
  const double freedom = 2.0 * static_cast<double>(count) - kRotationParameters;
  if (!(freedom > 0)) return undefined.covariance;
  noise = std::sqrt(squares / freedom);
  const cv::Matx33d covariance = information.inv() * (noise * noise);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) undefined.covariance(row, column) = covariance(row, column);
  return undefined.covariance;
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
  kind.parameters = kEssentialParameters;
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
    return refinement_.refine(set_, columns, threshold, parameters.covariance, candidates, pose);
  };
  if (!again()) return false;
  if (parameters.covariance && chanceShare() > kChanceWithoutSupport &&
      findSupport(matches, parameters.supported)) {
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
/// @return whether enough of the agreeing ones have it
bool PoseSearch::findSupport(const Correspondences& matches, const std::vector<std::uint8_t>* known) {
  if (known != nullptr) {
    gather(*known, search_set_.rows(), candidates_);
  } else {
    gather(matches, search_set_.rows(), supported_);
    order_.resize(set_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    support_.compute(supported_, input_.best_first != nullptr ? *input_.best_first : order_);
    candidates_ = support_.extended();
  }
  std::size_t count = 0;
  for (const std::uint32_t i : refinement_.agreeing()) count += candidates_[i];
  return count >= kMinSupported;
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
      poseCovariance(found.pose, refinement_.fitted(), fitted_threshold_, found.covariance);
  } else if (verdict.motion != Motion::kNone) {
    found.pose.rotation = verdict.rotation;
    found.covariance =
        rotationCovariance(verdict.rotation, set_, kRotationWidth * parameters.threshold, found.noise);
  }
}

std::optional<PoseResult> PoseSearch::find(const Correspondences& matches, const PoseParameters& parameters,
                                           const Deadline& deadline, Workspace& workspace,
                                           Selection& result) {
  EssentialModel& model = workspace.part<EssentialModel>();
  Proposal& proposal = workspace.part<ProsacProposal>();
  input_.readRays(matches, parameters.search.seed, result);
  const std::vector<std::uint32_t>& set = search_set_.choose(matches, input_.rows());
  if (!isEnough(set.size(), model, result)) return std::nullopt;
  input_.takeWithRays(matches, set, proposal, result);
  gatherRays(input_.rays(), set, set_);
  SearchOutcome outcome =
      search(input_.matches, {model, proposal}, parameters.search, input_.best_first, deadline, workspace);
  result.iterations = outcome.iterations;
  if (outcome.timed_out) reportEnd(outcome, parameters.max_seconds, result);
  Pose pose;
  const bool posed = outcome.best.exists() && outcome.best.inliers >= kMinAgreeing &&
                     choosePose(outcome.best.model, set_, parameters.threshold, pose);
  const bool refined = posed && refine(matches, parameters, pose);
  const Verdict verdict =
      verdict_.decide({set_, input_.matches.rays, input_.best_first, refined ? &pose : nullptr,
                       parameters.threshold, parameters.search.seed});
  if (verdict.motion == Motion::kNone) {
    fail(result, posed && !refined ? Status::kDegenerate : Status::kNoModel,
         posed && !refined ? "the matches do not determine a pose"
                           : "no motion of the camera explains more matches than chance");
    return std::nullopt;
  }
  PoseResult found;
  describe(parameters, verdict, found);
  return found;
}

}  // namespace corrsel::core
