#include "corrsel/selectors/acransac.h"

#include <algorithm>
#include <string>
#include <vector>

#include "base/deadline.h"
#include "base/text.h"
#include "base/workspace_scope.h"
#include "corrsel/selectors/usac.h"
#include "search/ordering.h"
#include "search/search.h"
#include "search/significant_model.h"

namespace corrsel::core {

AcransacOptions::AcransacOptions() {
  static_cast<ConsensusOptions&>(*this) = UsacOptions();
  min_confidence = kBelievedConfidence;
}

void AcransacOptions::visit(OptionVisitor& visitor) const {
  visitModel(visitor);
  visitSampler(visitor);
  visitor.integer(
      {"max_iterations", 0, 10000000, "-",
       "Hypotheses at most; 0 = 100000, or 850000 without descriptor distances, or 5000 for multigs"},
      &AcransacOptions::max_iterations);
  visitor.number({"widen", 1, 10, "-",
                  "Inlier threshold, in units of the threshold at which the model is the most significant"},
                 &AcransacOptions::widen);
  visitor.number({"min_threshold", 0, 100, "px",
                  "Least inlier threshold; 0 = 5 for a homography, 2 for a fundamental matrix"},
                 &AcransacOptions::min_threshold);
  visitor.number({"max_threshold", 0.01, 100, "px", "Largest inlier threshold, if it is above the least one"},
                 &AcransacOptions::max_threshold);
  visitSeedAndTime(visitor);
  visitConfidence(visitor);
}

Presets AcransacSelector::presets() const {
  return {{"h", {{"model", "homography"}}}, {"f", {{"model", "fundamental"}}}};
}

namespace {

/// Memory that is kept between calls.
struct AcransacMemory {
  Ordering ordering;
  std::vector<std::uint32_t> rows, best_first;
  NormalizedMatches normalized;
  SignificanceTest significance;
  std::vector<double> errors;
};

/// The inlier threshold of a model, px.
double inlierThreshold(const AcransacOptions& options, ModelKind kind, double most_significant) {
  constexpr double kLeastOfPlane = 5, kLeastOfLine = 2;
  const double least = options.min_threshold > 0        ? options.min_threshold
                       : kind == ModelKind::kHomography ? kLeastOfPlane
                                                        : kLeastOfLine;
  return std::clamp(options.widen * most_significant, least, std::max(least, options.max_threshold));
}

}  // namespace

void AcransacSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const Deadline deadline(options_.max_seconds);
  AcransacOptions options = options_;
  const bool either = options.model == ModelKind::kNone;
  if (either) options.model = ModelKind::kHomography;
  if (!isEnough(matches.size(), problemOf(options), result)) return;
  AcransacMemory& work = workspace.part<AcransacMemory>();
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options.seed), work.rows);
  normalizeMatches(matches, work.rows, work.normalized);
  work.significance.assign(matches);
  const std::vector<std::uint32_t>* order =
      orderForSampler(matches, options, work.rows, work.ordering, work.best_first, result);
  FrameHypotheses* const frames =
      framesForSampler(matches, options, work.rows, work.ordering, work.best_first);
  SignificantModel found =
      searchSignificantModel(work.normalized, work.significance, options, order, deadline, frames);
  TwoViewProblem problem = problemOf(options);
  options.model = ModelKind::kFundamental;
  const TwoViewProblem other = problemOf(options);
  if (either && !found.outcome.timed_out && matches.size() >= static_cast<std::size_t>(other.sample_size)) {
    // Frames do not give fundamental matrices.
    if (frames != nullptr) options.sampler = ConsensusOptions::Sampler::kProsac;
    order = orderForSampler(matches, options, work.rows, work.ordering, work.best_first, result);
    const SignificantModel second =
        searchSignificantModel(work.normalized, work.significance, options, order, deadline);
    const int iterations = found.outcome.iterations + second.outcome.iterations;
    const bool timed_out = second.outcome.timed_out;
    if (second.significance.confidence > found.significance.confidence) {
      found = second;
      problem = other;
    }
    found.outcome.iterations = iterations;
    found.outcome.timed_out = timed_out;
  }
  reportEnd(found.outcome, options.max_seconds, result);
  if (!found.outcome.best.exists()) return;
  if (found.significance.agreements == 0) {
    if (result.status == Status::kOk) result.status = Status::kNoModel;
    result.message += std::string(result.message.empty() ? "" : "; ") + "the best " + toString(problem.kind) +
                      " agrees with nothing but its sample";
    return;
  }
  result.model = found.model;
  result.model_kind = problem.kind;
  result.confidence = found.significance.confidence;
  const double threshold = inlierThreshold(options, problem.kind, found.significance.threshold);
  selectByModel(matches, problem.mask_residual, threshold, work.errors, result);
  result.message += (result.message.empty() ? "" : "; ") + toString(problem.kind) + " most significant at " +
                    formatNumber(found.significance.threshold) + " px with " +
                    std::to_string(found.significance.agreements) +
                    " matches at distinct places, threshold " + formatNumber(threshold) + " px";
}

}  // namespace corrsel::core
