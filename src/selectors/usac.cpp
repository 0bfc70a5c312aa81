#include "corrsel/selectors/usac.h"

#include "consensus/search.h"

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
  visitParts(visitor,
             {0,
              "Inlier threshold; 0 = 5 for a homography (10 unless error is smaller_transfer), 1.5 for a "
              "fundamental matrix",
              0, "Hypotheses at most; 0 = 100000, or 850000 without descriptor distances"});
}

Presets UsacSelector::presets() const {
  return {
      {"h", {{"model", "homography"}}},
      {"f", {{"model", "fundamental"}}},
      {"uniform", {{"sampler", "uniform"}}},
      {"paper", {{"error", "symmetric_transfer"}, {"one_to_one", "false"}, {"max_iterations", "850000"}}}};
}

void UsacSelector::run(const Correspondences& matches, Selection& result) const {
  // The thresholds of the paper are those for 1.5 px and for the transfer errors.
  constexpr double kFundamental = 1.5, kTransfer = 10.0, kSmallerTransfer = 5.0;
  const double standard = options_.model == ModelKind::kFundamental                ? kFundamental
                          : options_.error == UsacOptions::Error::kSmallerTransfer ? kSmallerTransfer
                                                                                   : kTransfer;
  searchConsensus(matches, options_, options_.threshold > 0 ? options_.threshold : standard, result);
}

}  // namespace corrsel::core
