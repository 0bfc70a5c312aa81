#include "corrsel/selectors/usac.h"

#include "consensus/search.h"

namespace corrsel::core {

UsacOptions::UsacOptions() {
  error = Error::kSymmetricTransfer;
  threshold = 0;
  max_iterations = 850000;
  confidence = 0.999;
  sampler = Sampler::kProsac;
  sprt = degensac = local_optimization = true;
}

void UsacOptions::visit(OptionVisitor& visitor) const {
  visitParts(visitor, 0,
             "Inlier threshold; 0 = the paper's: 10 for a homography, 1.5 for a fundamental matrix");
}

Presets UsacSelector::presets() const {
  return {{"h", {{"model", "homography"}}},
          {"f", {{"model", "fundamental"}}},
          {"uniform", {{"sampler", "uniform"}}}};
}

void UsacSelector::run(const Correspondences& matches, Selection& result) const {
  constexpr double kHomographyThreshold = 10.0, kFundamentalThreshold = 1.5;
  const double standard =
      options_.model == ModelKind::kHomography ? kHomographyThreshold : kFundamentalThreshold;
  searchConsensus(matches, options_, options_.threshold > 0 ? options_.threshold : standard, result);
}

}  // namespace corrsel::core
