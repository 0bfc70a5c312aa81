#include "corrsel/selectors/pose.h"

#include <cmath>

#include "calibrated/pose_search.h"
#include "geometry/essential.h"
#include "geometry/residual.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

struct PoseMemory {
  PoseSearch search;
  std::vector<double> errors;
};

/// Selects the matches that agree with the pose.
void selectByPose(const RayMatches& rays, double threshold, std::vector<double>& errors, Selection& result) {
  const PoseResult& found = *result.pose;
  const bool translated = found.motion == Motion::kGeneral || found.motion == Motion::kPlanar;
  const std::size_t n = rays.size();
  result.model_kind = translated ? ModelKind::kEssential : ModelKind::kRotation;
  result.model = translated ? essentialOf(found.pose) : found.pose.rotation;
  rayErrors(result.model_kind, result.model, rays, errors);
  const double width = (translated ? 1 : kRotationWidth) * threshold;
  result.score.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.score[i] = static_cast<float>(-errors[i]);
    const bool agrees =
        errors[i] <= width * width && (!translated || isInFront(found.pose, rays, i, threshold));
    result.mask[i] = agrees ? 1 : 0;
  }
  result.sigma = found.noise;
  result.scene = translated && found.motion == Motion::kGeneral ? SceneKind::kRigid
                 : found.motion == Motion::kRest                ? SceneKind::kAtRest
                                                                : SceneKind::kPlaneOrRotation;
}

}  // namespace

PoseOptions::PoseOptions() { min_confidence = kSignificantConfidence; }

void PoseOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"threshold", 0.01, 1000, "px", "Inlier threshold: the tangent Sampson error"},
                 &PoseOptions::threshold);
  visitor.flag("adaptive", "Refine the pose with a threshold that follows the noise", &PoseOptions::adaptive);
  visitor.flag("covariance", "Compute the covariance, and leave agreements by chance out of the refinement",
               &PoseOptions::covariance);
  visitor.integer({"max_iterations", 0, 10000000, "-", "Samples at most; 0 = 20000"},
                  &PoseOptions::max_iterations);
  visitor.number(
      {"confidence", 0, 1, "-", "Probability of an all-inlier sample at which the search stops; 1 = never"},
      &PoseOptions::confidence);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the samples"}, &PoseOptions::seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &PoseOptions::max_seconds);
  visitConfidence(visitor);
}

std::string PoseSelector::missingInput(const Correspondences& matches) const {
  return missingCameras(matches);
}

void PoseSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const Deadline deadline(options_.max_seconds);
  PoseParameters parameters;
  parameters.threshold = parameters.search.threshold = options_.threshold;
  parameters.adaptive = options_.adaptive;
  parameters.covariance = options_.covariance;
  parameters.max_seconds = options_.max_seconds;
  parameters.search.max_iterations = options_.max_iterations;
  parameters.search.confidence = options_.confidence;
  parameters.search.seed = static_cast<std::uint64_t>(options_.seed);
  parameters.prior = matches.prior;
  parameters.guess = matches.guess;
  auto& [search, errors] = workspace.part<PoseMemory>();
  result.pose = search.find(matches, parameters, deadline, workspace, result);
  if (result.pose) selectByPose(search.rays(), options_.threshold, errors, result);
}

}  // namespace corrsel::core
