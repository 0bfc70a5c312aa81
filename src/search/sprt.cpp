#include "search/sprt.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {
namespace {

constexpr double kMinDecision = 8.0;  // a good model is rejected with a probability of at most 1/8
constexpr double kMinDelta = 1e-4;    // one agreeing match must not outweigh everything
constexpr double kMaxShare =
    0.5;  // upper bound of delta as a share of epsilon; above it the hypotheses are hard to separate
constexpr double kRelativeChange = 0.1;  // of delta; a larger one updates the test
constexpr std::size_t kInterval = 50;    // rejected models between two updates of delta

}  // namespace

Sprt::Sprt(const SprtConstants& constants, double sample_share)
    : constants_(constants),
      sample_share_(sample_share),
      epsilon_(constants.epsilon),
      delta_(constants.delta) {
  design();
}

void Sprt::design() {
  delta_ = std::clamp(delta_, kMinDelta, kMaxShare * epsilon_);
  const double c =
      (1 - delta_) * std::log((1 - delta_) / (1 - epsilon_)) + delta_ * std::log(delta_ / epsilon_);
  const double k = constants_.model_time * c / constants_.models_per_sample + 1;
  double a = k;
  for (int i = 0; i < 10; ++i) a = k + std::log(a);
  decision_ = std::max(a, kMinDecision);
  log_consistent_ = std::log(delta_ / epsilon_);
  log_inconsistent_ = std::log((1 - delta_) / (1 - epsilon_));
  log_decision_ = std::log(decision_);
}

void Sprt::apply(ScoreRule& rule) const {
  rule.log_consistent = log_consistent_;
  rule.log_inconsistent = log_inconsistent_;
  rule.log_decision = log_decision_;
}

bool Sprt::addRejected(const ModelScore& score) {
  ++rejected_;
  seen_ += score.seen;
  agreed_ += score.inliers;
  if (rejected_ % kInterval != 0) return false;
  const double agreed = static_cast<double>(agreed_) / static_cast<double>(seen_) - sample_share_;
  const double estimate = std::clamp(agreed, kMinDelta, kMaxShare * epsilon_);
  if (std::abs(estimate - delta_) <= kRelativeChange * delta_) return false;
  delta_ = estimate;
  design();
  return true;
}

bool Sprt::addBest(double inlier_ratio) {
  constexpr double kMaxEpsilon = 0.999;
  const double epsilon = std::min(inlier_ratio, kMaxEpsilon);
  if (!(epsilon > epsilon_)) return false;
  epsilon_ = epsilon;
  design();
  return true;
}

}  // namespace corrsel::core
