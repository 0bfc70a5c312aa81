#include "corrsel/selectors/usac.h"

#include "search/selecting.h"

namespace corrsel::core {

UsacOptions::UsacOptions() {
  error = Error::kSmallerTransfer;
  threshold = 0;
  confidence = 0.999;
  one_to_one = sprt = degensac = local_optimization = true;
}

void UsacOptions::visit(OptionVisitor& visitor) const {
  visitParts(visitor,
             {0,
              "Inlier threshold; 0 = 5 for a homography (10 unless error is smaller_transfer), 1.5 for a "
              "fundamental and 1 for an essential matrix",
              0,
              "Hypotheses at most; 0 = 60000 for a homography, 40000 for a fundamental and 20000 for an "
              "essential matrix"});
}

Presets UsacSelector::presets() const {
  return {
      {"h", {{"model", "homography"}}},
      {"f", {{"model", "fundamental"}}},
      {"e", {{"model", "essential"}}},
      {"uniform", {{"sampler", "uniform"}}},
      {"frames", {{"sampler", "frames"}}},
      {"paper", {{"error", "symmetric_transfer"}, {"one_to_one", "false"}, {"max_iterations", "850000"}}}};
}

void UsacSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  // The paper's thresholds, except for the smaller error, which the paper does not have.
  constexpr double kFundamental = 1.5, kTransfer = 10.0, kSmallerTransfer = 5.0, kRays = 1.0;
  SearchParameters parameters = parametersOf(options_);
  if (!(options_.threshold > 0)) {
    parameters.threshold = options_.model == ModelKind::kEssential                  ? kRays
                           : options_.model == ModelKind::kFundamental              ? kFundamental
                           : options_.error == UsacOptions::Error::kSmallerTransfer ? kSmallerTransfer
                                                                                    : kTransfer;
  }
  selectByConsensus(
      matches, {modelOf(options_.model, options_.error, workspace), proposalOf(options_.sampler, workspace)},
      parameters, options_.max_seconds, workspace, result);
}

}  // namespace corrsel::core
