#include "corrsel/selectors/usac.h"

#include "search/search.h"
#include "selectors/parts/model_choice.h"

namespace corrsel::core {

UsacOptions::UsacOptions() {
  error = Error::kSmallerTransfer;
  threshold = 0;
  max_iterations = 0;
  confidence = 0.999;
  sampler = Sampler::kProsac;
  one_to_one = sprt = degensac = local_optimization = true;
}

void UsacOptions::visit(OptionVisitor& visitor) const {
  visitParts(
      visitor,
      {0,
       "Inlier threshold; 0 = 5 for a homography (10 unless error is smaller_transfer), 1.5 for a "
       "fundamental matrix",
       0, "Hypotheses at most; 0 = 100000, or 850000 without descriptor distances, or 5000 for multigs"});
}

Presets UsacSelector::presets() const {
  return {
      {"h", {{"model", "homography"}}},
      {"f", {{"model", "fundamental"}}},
      {"uniform", {{"sampler", "uniform"}}},
      {"frames", {{"sampler", "frames"}}},
      {"paper", {{"error", "symmetric_transfer"}, {"one_to_one", "false"}, {"max_iterations", "850000"}}}};
}

void UsacSelector::run(const Correspondences& matches, Workspace&, Selection& result) const {
  // The paper's thresholds, except for the smaller error, which the paper does not have.
  constexpr double kFundamental = 1.5, kTransfer = 10.0, kSmallerTransfer = 5.0;
  const bool given = options_.threshold > 0;
  const double homography = given                                                    ? options_.threshold
                            : options_.error == UsacOptions::Error::kSmallerTransfer ? kSmallerTransfer
                                                                                     : kTransfer;
  const double fundamental = given ? options_.threshold : kFundamental;
  if (options_.model == ModelKind::kNone) {
    searchEitherModel(matches, options_, homography, fundamental, result);
  } else {
    searchConsensus(matches, options_, options_.model == ModelKind::kFundamental ? fundamental : homography,
                    result);
  }
}

}  // namespace corrsel::core
