#include "posterior/match_probability.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "geometry/residual.h"
#include "posterior/noise_scale.h"

namespace corrsel::core {
namespace {

constexpr double kNoiseCut = 2;  // times t: larger residuals do not count for the noise

double noiseOf(const AnsweredMatches& answered, const std::vector<double>& errors, std::size_t outliers) {
  const bool homography = mapsPoints(answered.kind);
  ResidualKind kind;
  kind.dimensions = homography ? 2 : 1;
  kind.parameters = homography ? 8 : 7;
  kind.cut = kNoiseCut * (homography ? AnswerTerms::kHomographyScale : AnswerTerms::kFundamentalScale);
  kind.background = static_cast<double>(outliers) * AnswerTerms::outlierDensity(answered);
  return estimateNoiseScale(errors, kind).sigma;
}

}  // namespace

double probabilityOf(const ProbabilityTerms& terms, const ProbabilityTerms& weights) {
  return 1 / (1 + std::exp(-std::inner_product(terms.begin(), terms.end(), weights.begin(), 0.0)));
}

void MatchProbability::compute(const AnsweredMatches& answered) {
  sigma_ = std::numeric_limits<double>::quiet_NaN();
  const std::size_t n = answered.matches.size();
  probability_.assign(n, 0);
  if (std::none_of(answered.mask.begin(), answered.mask.end(), [](std::uint8_t m) { return m != 0; })) return;
  const bool modelled = answered.kind != ModelKind::kNone;
  errors_.clear();
  if (modelled) selectionErrors(answered.kind, answered.model, answered.matches, rays_, errors_);
  const AnswerTerms terms(answered, errors_);
  if (modelled) sigma_ = noiseOf(answered, errors_, terms.farOthers());
  const ProbabilityTerms& weights = modelled ? kWeightsWithModel : kWeightsWithoutModel;
  for (std::size_t i = 0; i < n; ++i)
    probability_[i] = static_cast<float>(probabilityOf(terms.of(i), weights));
}

}  // namespace corrsel::core
