#include "corrsel/selectors/planes.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "base/deadline.h"
#include "base/gather.h"
#include "base/workspace_scope.h"
#include "consensus/ordering.h"
#include "consensus/search.h"
#include "consensus/significant_model.h"
#include "corrsel/selectors/usac.h"
#include "geometry/residual.h"

namespace corrsel::core {

PlanesOptions::PlanesOptions() {
  static_cast<ConsensusOptions&>(*this) = UsacOptions();
  sampler = Sampler::kLocal;
  max_iterations = 1000;
  min_confidence = kBelievedConfidence;
}

void PlanesOptions::visit(OptionVisitor& visitor) const {
  visitSampler(visitor);
  visitor.flag("frames", "Use local affine frames where there are any, in place of samples",
               &PlanesOptions::frames);
  visitor.integer({"max_iterations", 1, 10000000, "-", "Hypotheses per plane at most"},
                  &PlanesOptions::max_iterations);
  visitor.integer({"max_planes", 1, 100, "-", "Planes at most"}, &PlanesOptions::max_planes);
  visitor.number(
      {"relative_cut", 0, 1, "-", "Least confidence of a further plane, relative to that of the first one"},
      &PlanesOptions::relative_cut);
  visitor.number({"widen", 1, 10, "-",
                  "Inlier threshold, in units of the threshold at which the plane is the most significant"},
                 &PlanesOptions::widen);
  visitor.number({"min_threshold", 0.01, 100, "px", "Least inlier threshold"}, &PlanesOptions::min_threshold);
  visitor.number({"max_threshold", 0.01, 100, "px", "Largest inlier threshold, if it is above the least one"},
                 &PlanesOptions::max_threshold);
  visitSeedAndTime(visitor);
  visitConfidence(visitor);
}

Presets PlanesSelector::presets() const { return {{"first", {{"max_planes", "1"}}}}; }

namespace {

using Rows = std::vector<std::uint32_t>;

constexpr std::size_t kLeastMatches = 8;  // that are left, for a further plane

/// Memory that is kept between calls.
struct PlanesMemory {
  Ordering ordering;
  Rows rows, identity, best_first;
  Correspondences rest;  // the matches at `rows`
  NormalizedMatches normalized;
  SignificanceTest significance;
  std::vector<double> errors, smallest;
};

/// Selects what lies within the threshold of one more plane, and lowers the smallest errors.
void addPlane(std::int32_t number, double threshold, PlanesMemory& work, Selection& result) {
  for (std::size_t i = 0; i < work.errors.size(); ++i) {
    const double error = work.errors[i];
    const bool within = error <= threshold * threshold;
    // A match within the threshold of a plane takes the error of that plane, even if it is nearer to another
    // plane with a lower threshold.
    const bool first = within && result.group[i] < 0;
    const bool nearer = error < work.smallest[i] && (within || result.group[i] < 0);
    if (!first && !nearer) continue;
    work.smallest[i] = error;
    if (!within) continue;
    result.mask[i] = 1;
    result.group[i] = number;
  }
}

}  // namespace

void PlanesSelector::run(const Correspondences& matches, Selection& result) const {
  const Deadline deadline(options_.max_seconds);
  PlanesOptions options = options_;
  if (options.frames && !matches.left_frame.empty() && !matches.right_frame.empty())
    options.sampler = ConsensusOptions::Sampler::kFrames;
  const TwoViewProblem problem = problemOf(options);
  if (!isEnough(matches.size(), problem, result)) return;
  PlanesMemory& work = WorkspaceScope::part<PlanesMemory>();
  const std::size_t n = matches.size();
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options.seed), work.rows);
  work.smallest.assign(n, std::numeric_limits<double>::infinity());
  work.errors.resize(n);
  SearchOutcome all;  // of all searches
  std::int32_t planes = 0;
  result.group.assign(n, -1);
  while (planes < options.max_planes && !all.timed_out &&
         (planes == 0 || work.rows.size() >= kLeastMatches)) {
    gather(matches, work.rows, work.rest);
    work.identity.resize(work.rows.size());
    std::iota(work.identity.begin(), work.identity.end(), 0U);
    normalizeMatches(work.rest, work.identity, work.normalized);
    work.significance.assign(work.rest);
    // Of all remarks, only the first search's.
    Selection remarks;
    const Rows* const order = orderForSampler(work.rest, options, work.identity, work.ordering,
                                              work.best_first, planes == 0 ? result : remarks);
    FrameHypotheses* const frames =
        framesForSampler(work.rest, options, work.identity, work.ordering, work.best_first);
    const SignificantModel found =
        searchSignificantModel(work.normalized, work.significance, options, order, deadline, frames);
    all.iterations += found.outcome.iterations;
    all.timed_out = found.outcome.timed_out;
    if (planes == 0) {
      all.best = found.outcome.best;
      all.no_valid_sample = found.outcome.no_valid_sample;
    }
    const double confidence = found.significance.confidence;
    if (!found.outcome.best.exists() || confidence < kBelievedConfidence ||
        confidence < options.relative_cut * result.confidence)
      break;
    if (planes == 0) {
      result.model = found.model;
      result.model_kind = ModelKind::kHomography;
      result.confidence = confidence;
    }
    const double threshold = std::clamp(options.widen * found.significance.threshold, options.min_threshold,
                                        std::max(options.min_threshold, options.max_threshold));
    pixelErrors(problem.mask_residual, found.model, matches, work.errors.data());
    addPlane(planes, threshold, work, result);
    ++planes;
    const std::size_t before = work.rows.size();
    work.rows.erase(
        std::remove_if(work.rows.begin(), work.rows.end(),
                       [&](std::uint32_t row) { return work.errors[row] <= threshold * threshold; }),
        work.rows.end());
    if (work.rows.size() == before) break;
  }
  reportEnd(all, options.max_seconds, result);
  if (planes == 0) {
    result.group.clear();
    if (result.status == Status::kOk) {
      result.status = Status::kNoModel;
      result.message = "no homography agrees with more matches than chance explains";
    }
    return;
  }
  result.score.resize(n);
  for (std::size_t i = 0; i < n; ++i) result.score[i] = static_cast<float>(-work.smallest[i]);
  result.message +=
      (result.message.empty() ? "" : "; ") + std::to_string(planes) + (planes == 1 ? " plane" : " planes");
}

}  // namespace corrsel::core
