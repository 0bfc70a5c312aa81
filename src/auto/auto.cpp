#include "corrsel/selectors/auto.h"

#include <string>

#include "auto/answer.h"
#include "auto/decision.h"
#include "auto/gathering.h"
#include "auto/memory.h"
#include "base/coordinate_order.h"
#include "base/text.h"

namespace corrsel::core {

AutoOptions::AutoOptions() { min_confidence = kSignificantConfidence; }

void AutoOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("model",
                 {{Model::kAuto, "auto", "Found out from the matches"},
                  {Model::kHomography, "homography", "Planes, or cameras that only turn"},
                  {Model::kFundamental, "fundamental", "Epipolar geometry of rigid scenes"}},
                 "Model to which the answer is restricted", &AutoOptions::model);
  visitor.number(
      {"threshold", 0, 1000, "px",
       "Inlier threshold of a homography: the smaller one of the transfer errors in both images; 0 = "
       "5 px, and more where the noise of the inliers is larger"},
      &AutoOptions::threshold);
  visitor.number(
      {"fundamental_threshold", 0, 1000, "px",
       "Inlier threshold of a fundamental matrix: Sampson distance; 0 = 1.5 px, and more where the "
       "noise of the inliers is larger"},
      &AutoOptions::fundamental_threshold);
  visitor.integer({"hard_search", 0, 10000000, "-",
                   "Hypotheses that are drawn where nothing else has found a model, more of them for few "
                   "matches; 0 = none"},
                  &AutoOptions::hard_search);
  visitConfidence(visitor);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the samplers"}, &AutoOptions::seed);
  visitor.integer({"threads", 1, 256, "-", "Threads that may be used; the result does not depend on it"},
                  &AutoOptions::threads);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &AutoOptions::max_seconds);
}

Presets AutoSelector::presets() const {
  return {
      {"h", {{"model", "homography"}}}, {"f", {{"model", "fundamental"}}}, {"fast", {{"hard_search", "0"}}}};
}

namespace {

constexpr std::size_t kMinMatches = 6;

void reportTimeLimit(const Effort& effort, double max_seconds, Selection& result) {
  if (effort.hypotheses == 0) {
    const std::size_t n = result.mask.size();
    result = Selection{};
    result.mask.assign(n, 0);
    result.probability.assign(n, 0);
  }
  result.status = effort.hypotheses == 0 ? Status::kTooLarge : Status::kTimeLimit;
  result.scene = SceneKind::kUnknown;  // a part of the evidence is missing
  result.message += (result.message.empty() ? "" : "; ") + std::string("stopped after ") +
                    std::to_string(effort.hypotheses) +
                    " hypotheses, max_seconds = " + formatNumber(max_seconds);
}

}  // namespace

void AutoSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  result.probability.assign(matches.size(), 0);
  if (matches.size() < kMinMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(matches.size()) + " matches, auto needs " + std::to_string(kMinMatches);
    return;
  }
  if (allEqual(matches.left_x, matches.left_y) || allEqual(matches.right_x, matches.right_y)) {
    result.status = Status::kDegenerate;
    result.message = "all points of one image are equal";
    return;
  }
  AutoMemory& memory = workspace.part<AutoMemory>();
  Effort effort(options_.max_seconds, matches.size(), workspace);
  memory.assign(matches, options_);
  Gathering gathering(options_, memory, effort);
  gathering.start();
  Decision decision = decide(gathering.evidence(), options_.model);
  for (; decision.need != Need::kNone; decision = decide(gathering.evidence(), options_.model))
    gathering.gather(decision.need);
  if (options_.model != AutoOptions::Model::kHomography) gathering.findPose();
  writeAnswer(decision, gathering.evidence(), options_, memory, effort, result);
  if (effort.timed_out) reportTimeLimit(effort, options_.max_seconds, result);
}

}  // namespace corrsel::core
