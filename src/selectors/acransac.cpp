#include "corrsel/selectors/acransac.h"

#include <algorithm>
#include <string>

#include "base/deadline.h"
#include "base/text.h"
#include "search/selecting.h"
#include "search/significant_model.h"

namespace corrsel::core {

AcransacOptions::AcransacOptions() { min_confidence = kSignificantConfidence; }

void AcransacOptions::visit(OptionVisitor& visitor) const {
  visitCalibratedModel(visitor, &AcransacOptions::model);
  visitSampler(visitor);
  visitor.integer({"max_iterations", 0, 10000000, "-",
                   "Hypotheses at most; 0 = 60000 for a homography, 40000 for a fundamental and 20000 for an "
                   "essential matrix"},
                  &AcransacOptions::max_iterations);
  visitor.number({"widen", 1, 10, "-",
                  "Inlier threshold, in units of the threshold at which the model is the most significant"},
                 &AcransacOptions::widen);
  visitor.number({"min_threshold", 0, 100, "px",
                  "Smallest inlier threshold; 0 = 5 for a homography, 2 for a fundamental and 1.5 for an "
                  "essential matrix"},
                 &AcransacOptions::min_threshold);
  visitor.number(
      {"max_threshold", 0.01, 100, "px", "Largest inlier threshold, if it is above the smallest one"},
      &AcransacOptions::max_threshold);
  visitSeedAndTime(visitor);
  visitConfidence(visitor);
}

Presets AcransacSelector::presets() const {
  return {
      {"h", {{"model", "homography"}}}, {"f", {{"model", "fundamental"}}}, {"e", {{"model", "essential"}}}};
}

namespace {

/// Memory that is kept between calls.
struct AcransacMemory {
  SearchInput input;
  SignificanceTest significance;
};

/// The inlier threshold of a model, px.
double inlierThreshold(const AcransacOptions& options, ModelKind kind, double most_significant) {
  constexpr double kMinOfPlane = 5, kMinOfLine = 2, kMinOfRays = 1.5;
  const double min_threshold = options.min_threshold > 0         ? options.min_threshold
                               : kind == ModelKind::kHomography  ? kMinOfPlane
                               : kind == ModelKind::kFundamental ? kMinOfLine
                                                                 : kMinOfRays;
  return std::clamp(options.widen * most_significant, min_threshold,
                    std::max(min_threshold, options.max_threshold));
}

}  // namespace

void AcransacSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const Deadline deadline(options_.max_seconds);
  const SearchParts parts = {modelOf(options_.model, ConsensusOptions::Error::kSmallerTransfer, workspace),
                             proposalOf(options_.sampler, workspace)};
  SearchParameters parameters;
  parameters.max_iterations = options_.max_iterations;
  parameters.seed = static_cast<std::uint64_t>(options_.seed);
  auto& [input, significance] = workspace.part<AcransacMemory>();
  if (!input.takeAll(matches, parts, parameters.seed, result)) return;
  significance.assign(matches);
  const SignificantModel found = searchSignificantModel(input.matches, significance, parts, parameters,
                                                        input.best_first, deadline, workspace);
  reportEnd(found.outcome, options_.max_seconds, result);
  if (!found.outcome.best.exists()) return;
  const std::string kind = toString(options_.model);
  if (found.significance.agreements == 0) {
    if (result.status == Status::kOk) result.status = Status::kNoModel;
    addRemark(result, "the best " + kind + " agrees with nothing but its sample");
    return;
  }
  result.confidence = found.significance.confidence;
  const double threshold = inlierThreshold(options_, options_.model, found.significance.threshold);
  selectByModel(matches, parts.model, found.model, threshold, workspace, result);
  addRemark(result, kind + " most significant at " + formatNumber(found.significance.threshold) +
                        " px with " + std::to_string(found.significance.agreements) +
                        " matches at distinct places, threshold " + formatNumber(threshold) + " px");
}

}  // namespace corrsel::core
