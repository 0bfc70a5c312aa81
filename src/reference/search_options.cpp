#include "reference/search_options.h"

namespace corrsel::core {

void ReferenceSearchOptions::visit(OptionVisitor& visitor) const {
  visitModel(visitor, &ReferenceSearchOptions::model);
  visitor.number(
      {"threshold", 0, 1000, "px",
       "Inlier threshold: the error of a homography, Sampson distance of a fundamental matrix; 0 = "
       "the default of the method"},
      &ReferenceSearchOptions::threshold);
  visitor.integer({"max_iterations", 0, 10000000, "-", "Hypotheses at most; 0 = the default of the method"},
                  &ReferenceSearchOptions::max_iterations);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the samples"}, &ReferenceSearchOptions::seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &ReferenceSearchOptions::max_seconds);
  visitConfidence(visitor);
}

void selectByUsac(const Correspondences& matches, const ReferenceSearchOptions& options, Proposal& proposal,
                  Workspace& workspace, Selection& result) {
  constexpr double kFundamental = 1.5, kHomography = 5.0;  // the thresholds of usac, px
  SearchParameters parameters;
  parameters.threshold = options.threshold > 0                      ? options.threshold
                         : options.model == ModelKind::kFundamental ? kFundamental
                                                                    : kHomography;
  parameters.max_iterations = options.max_iterations;
  parameters.seed = static_cast<std::uint64_t>(options.seed);
  selectByConsensus(matches, {modelOf(options.model), proposal}, parameters, options.max_seconds, workspace,
                    result);
}

}  // namespace corrsel::core
