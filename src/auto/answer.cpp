#include "auto/answer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "corrsel/selectors/planes.h"
#include "search/homography_model.h"
#include "search/local_proposal.h"

namespace corrsel::core {
namespace {

constexpr int kPlaneHypotheses = 300;
constexpr double kTwoTier = 2;     // local support allows this many times the error of F
constexpr double kRoughScene = 5;  // times what chance gives: as many inliers of F without local support
                                   // mean that depth jumps

/// Writes the mask of what agrees with the fundamental matrix and its surroundings.
void takeFundamentalInliers(AutoMemory& memory) {
  const AutoMemory::Mask &local = memory.support.local(), &extended = memory.support.extended();
  const std::vector<double>& errors = memory.fundamental_errors;
  const std::size_t n = memory.size();
  const double squared = memory.thresholds.fundamental * memory.thresholds.fundamental;
  memory.answer.assign(n, 0);
  memory.core.assign(n, 0);
  std::size_t unsupported = 0, inliers = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const bool inlier = errors[i] <= squared;
    memory.answer[i] = inlier || (extended[i] != 0 && errors[i] <= kTwoTier * kTwoTier * squared) ? 1 : 0;
    memory.core[i] = local[i] != 0 && memory.answer[i] != 0 ? 1 : 0;
    unsupported += inlier && extended[i] == 0 ? 1 : 0;
    inliers += inlier ? 1 : 0;
  }
  const double chance = 2 * std::sqrt(2.0) * memory.thresholds.fundamental / std::sqrt(memory.support.area());
  if (static_cast<double>(unsupported) < kRoughScene * chance * static_cast<double>(n - inliers))
    memory.plausibility.filter(memory.matches, memory.support.maps(), memory.core, memory.answer);
}

/// Adds the inliers of the homography to the mask of a rigid scene, if the plane is a part of it: half of the
/// inliers must agree with the fundamental matrix. Two coordinates that agree with the plane are more
/// evidence than one that agrees with an epipolar line, so the error of the latter may be larger.
void addPlaneOfScene(AutoMemory& memory) {
  const AutoMemory::Mask& inliers = memory.homography_inliers;
  const std::vector<double>& errors = memory.fundamental_errors;
  const double squared = memory.thresholds.fundamental * memory.thresholds.fundamental;
  std::size_t on = 0, agreeing = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (inliers[i] == 0) continue;
    ++on;
    agreeing += errors[i] <= kTwoTier * kTwoTier * squared ? 1 : 0;
  }
  if (2 * agreeing < on) return;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (inliers[i] != 0 && errors[i] <= memory.thresholds.homography * memory.thresholds.homography)
      memory.answer[i] = 1;
}

/// Adds to the mask, which so far holds what agrees with the model, the planes of other motions and the
/// extended local set, and numbers the motions.
/// @param explained  per match: 1 = near the model; these do not take part in the search for planes
void addMotions(const AutoOptions& options, const AutoMemory::Mask& explained, AutoMemory& memory,
                Effort& effort, Selection& result) {
  const AutoMemory::Mask& extended = memory.support.extended();
  memory.rest.clear();
  for (std::uint32_t i = 0; i < memory.size(); ++i)
    if (memory.answer[i] == 0 && explained[i] == 0) memory.rest.push_back(i);
  memory.searched.clear();
  for (const std::uint32_t i : memory.by_support)
    if (extended[i] != 0) memory.searched.push_back(i);
  PlanesOptions planes_options;
  planes_options.max_iterations = kPlaneHypotheses;
  planes_options.seed = options.seed;
  Selection remarks;
  const HomographyModel homography;
  const SearchParts parts = {homography, effort.workspace.part<LocalProposal>()};
  memory.planes.find(memory.matches, memory.rest, &memory.searched, parts, planes_options, effort.deadline,
                     effort.workspace, remarks);
  effort.add(memory.planes.outcome());
  result.group.resize(memory.size());
  for (std::size_t i = 0; i < memory.size(); ++i) {
    const std::int32_t plane = memory.planes.group()[i];
    result.group[memory.rows[i]] = memory.answer[i] != 0 ? 0 : plane >= 0 ? plane + 1 : -1;
    memory.answer[i] |= plane >= 0 || extended[i] != 0 ? 1 : 0;
  }
}

void setModel(ModelKind kind, const cv::Matx33d& model, double confidence, Selection& result) {
  result.model_kind = kind;
  result.model = model;
  result.confidence = confidence;
}

}  // namespace

void writeAnswer(const Decision& decision, const Evidence& evidence, const AutoOptions& options,
                 AutoMemory& memory, Effort& effort, Selection& result) {
  result.status = decision.status;
  result.scene = decision.scene;
  result.message = decision.message;
  if (decision.scene != SceneKind::kNothing) {
    result.pose = evidence.pose;
    result.guess = evidence.guess;
  }
  switch (decision.answer) {
    case Answer::kNothing:
      return;
    case Answer::kLocal:
      memory.answer = memory.support.extended();
      result.confidence = *evidence.local_confidence;
      break;
    case Answer::kHomography:
    case Answer::kHomographyAndMore:
      memory.answer = memory.homography_inliers;
      setModel(ModelKind::kHomography, evidence.homography.model, evidence.homography.confidence, result);
      break;
    case Answer::kFundamental:
    case Answer::kFundamentalAndMore:
      takeFundamentalInliers(memory);
      if (isSignificant(evidence.homography.confidence)) addPlaneOfScene(memory);
      setModel(evidence.fundamental->kind, evidence.fundamental->model, evidence.fundamental->confidence,
               result);
  }
  if (decision.answer == Answer::kHomographyAndMore) {
    addMotions(options, memory.near_homography, memory, effort, result);
    result.confidence = std::max(result.confidence, *evidence.local_confidence);
  } else if (decision.answer == Answer::kFundamentalAndMore) {
    addMotions(options, memory.near_fundamental, memory, effort, result);
    result.confidence = std::max(result.confidence, memory.significance.local(memory.answer).confidence);
  }
  memory.probability.compute(
      {memory.matches, memory.support, memory.answer, result.model_kind, result.model, result.confidence});
  result.sigma = memory.probability.sigma();
  result.score.resize(memory.size());
  for (std::size_t i = 0; i < memory.size(); ++i) {
    result.mask[memory.rows[i]] = memory.answer[i];
    result.probability[memory.rows[i]] = memory.probability.probability()[i];
    result.score[memory.rows[i]] = memory.support.support()[i];
  }
  result.iterations =
      static_cast<int>(std::min<std::uint64_t>(effort.hypotheses, std::numeric_limits<int>::max()));
}

}  // namespace corrsel::core
