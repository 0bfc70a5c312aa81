#include "calibrated/guess_search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>  // inv()

#include "geometry/essential.h"
#include "geometry/rotation_vector.h"
#include "search/essential_model.h"
#include "search/local_optimization.h"
#include "search/prior_models.h"
#include "search/search.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinAgreeing = 8;
constexpr int kSamples = 1000;
constexpr double kSampleConfidence = 0.99;

/// Median size of a pixel of the right rays, rad.
double pixelAngle(const RayMatches& rays) {
  std::vector<double> angles(rays.size());
  for (std::size_t i = 0; i < angles.size(); ++i) angles[i] = rays.right.pixelAngle(i);
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

}  // namespace

std::optional<cv::Matx33d> hypothesisOfGuess(const MotionGuess& guess, const GuessSearchInput& input,
                                             const SearchParameters& parameters, const Deadline& deadline,
                                             Workspace& workspace, int& iterations) {
  constexpr double kSigmas = 2, kFarSigmas = 6, kFarThresholds = 6;
  const double angle = pixelAngle(input.rays);
  double threshold = std::hypot(parameters.threshold, kSigmas * guess.rotation_sigma / angle);
  KnownRotationModel& known = workspace.part<KnownRotationModel>();
  known.setPrior(PosePrior::ofRotation(guess.rotation));
  std::optional<cv::Matx33d> first;
  if (guess.translation) first = essentialOf({guess.rotation, *guess.translation}) * std::sqrt(0.5);
  SearchParameters rough = parameters;
  rough.threshold = threshold;
  rough.max_iterations = kSamples;
  rough.confidence = std::min(parameters.confidence, kSampleConfidence);
  const SearchOutcome outcome =
      search(input.matches, {known, input.proposal, nullptr, first ? &*first : nullptr}, rough,
             input.best_first, deadline, workspace);
  iterations = outcome.iterations;
  if (!outcome.best.exists() || outcome.timed_out) return std::nullopt;
  const Model& essential = workspace.part<EssentialModel>();
  Candidate best = outcome.best;
  for (bool last = false; !last; threshold /= 2) {
    last = threshold <= parameters.threshold;
    const double width = last ? parameters.threshold : threshold;
    const Verifier verifier(input.matches, essential.traits.residual, width * input.matches.scale,
                            parameters.msac);
    const cv::Matx33d model = best.model;
    best = {};
    if (!verifier.improve(model, best)) return std::nullopt;
    optimizeLocally(essential, verifier, best);
  }
  Pose pose;
  if (best.inliers < kMinAgreeing || !choosePose(best.model, input.rays, parameters.threshold, pose))
    return std::nullopt;
  const double limit = kFarSigmas * guess.rotation_sigma + kFarThresholds * parameters.threshold * angle;
  if (cv::norm(rotationVector(pose.rotation * guess.rotation.t())) > limit) return std::nullopt;
  return best.model;
}

bool agreesWithGuess(const PoseResult& pose, const MotionGuess& guess) {
  constexpr double kMaxSquared = 14.2;
  constexpr double kRounding = 1e-9;  // rad
  const double variance = guess.rotation_sigma * guess.rotation_sigma + kRounding * kRounding;
  cv::Matx33d covariance = cv::Matx33d::eye() * variance;
  const cv::Matx33d own = pose.covariance.get_minor<3, 3>(0, 0);
  if (std::isfinite(cv::norm(own))) covariance += own;
  const auto agrees = [&](const cv::Matx33d& rotation) {
    const cv::Vec3d turn = rotationVector(rotation * guess.rotation.t());
    return turn.dot(covariance.inv() * turn) <= kMaxSquared;
  };
  return agrees(pose.pose.rotation) || (pose.second && agrees(pose.second->rotation));
}

}  // namespace corrsel::core
