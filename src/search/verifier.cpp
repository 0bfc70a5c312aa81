#include "search/verifier.h"

#include <algorithm>

#include "geometry/residual.h"

namespace corrsel::core {
namespace {

/// Probability with which the bail-out may give up a model that is better than the best.
constexpr double kLogBailOutRisk = -27.6;  // ln(1e-12)

}  // namespace

Verifier::Verifier(const NormalizedMatches& matches, Residual residual, double threshold, bool msac,
                   DistinctSupport* distinct)
    : matches_(matches), residual_(residual), rule_{}, distinct_(distinct) {
  // Smaller and larger than any useful squared threshold, but well within the range of floats.
  constexpr double kNothing = 1e-30, kEverything = 1e30;
  rule_.squared_threshold = static_cast<float>(std::clamp(threshold * threshold, kNothing, kEverything));
  // Hoeffding's inequality: the mean cost of `seen` random matches, a number in [0, kOutlierCost], exceeds
  // its expectation by d with a probability of at most exp(-2 seen d^2 / kOutlierCost^2).
  rule_.squared_margin =
      -0.5 * kLogBailOutRisk * static_cast<double>(ScoreRule::kOutlierCost) * ScoreRule::kOutlierCost;
  rule_.cost_per_error = msac ? static_cast<float>(ScoreRule::kOutlierCost) / rule_.squared_threshold : 0.0F;
}

ModelScore Verifier::score(const cv::Matx33d& model, std::int64_t limit) const {
  ScoreRule rule = rule_;
  rule.limit = limit;
  return countOnce(model, limit,
                   kernels().residuals.score[static_cast<std::size_t>(residual_)](
                       residualModel(residual_, model), matches_.columns(), rule));
}

ModelScore Verifier::countOnce(const cv::Matx33d& model, std::int64_t limit, ModelScore score) const {
  if (distinct_ == nullptr || distinct_->shared().empty() || score.rejected) return score;
  const DistinctSupport::Surplus surplus = distinct_->surplus(residual_, model, rule_.squared_threshold);
  score.cost += rule_.cost_per_error > 0
                    ? surplus.saved
                    : static_cast<std::int64_t>(surplus.inliers) * ScoreRule::kOutlierCost;
  score.surplus = std::min(surplus.inliers, score.inliers);
  score.rejected = score.cost >= limit;
  return score;
}

ModelScore Verifier::test(const cv::Matx33d& model, std::int64_t limit, const Sprt& sprt) {
  // The error in one direction costs half the work and never exceeds the symmetric error, so a model that it
  // rejects is bad.
  const Residual quick = residual_ == Residual::kSymmetricTransfer ? Residual::kTransfer : residual_;
  ScoreRule rule = rule_;
  rule.limit = quick == residual_ ? limit : std::numeric_limits<std::int64_t>::max();
  rule.start = start_;
  sprt.apply(rule);
  const ModelScore tested = kernels().residuals.score[static_cast<std::size_t>(quick)](
      residualModel(quick, model), matches_.columns(), rule);
  start_ += (tested.seen + ScoreRule::kBlock - 1) / ScoreRule::kBlock * ScoreRule::kBlock;
  if (start_ >= matches_.size()) start_ = 0;
  if (tested.rejected) return tested;
  if (quick == residual_) return countOnce(model, limit, tested);
  // The errors in both directions cost at least as much.
  if (tested.cost < limit) return score(model, limit);
  ModelScore given_up = tested;
  given_up.rejected = true;
  return given_up;
}

bool Verifier::improve(const cv::Matx33d& model, Candidate& best) const {
  const ModelScore scored = score(model, best.cost);
  if (scored.rejected) return false;
  best = {model, scored.cost, scored.inliers, scored.inliers - scored.surplus};
  return true;
}

}  // namespace corrsel::core
