#include "search/stopping.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "search/significance.h"

namespace corrsel::core {

StoppingRule::StoppingRule(double confidence, std::size_t matches, int sample_size)
    : log_failure_(confidence < 1 ? std::log1p(-confidence) : -std::numeric_limits<double>::infinity()),
      matches_(matches),
      sample_size_(sample_size),
      needed_(std::numeric_limits<double>::infinity()) {
  epochs_.reserve(16);
  epochs_.push_back({0.0, 0});
}

double StoppingRule::probability(std::size_t inliers, std::size_t pool) const {
  double result = 1;
  for (int k = 0; k < sample_size_; ++k) {
    const auto taken = static_cast<double>(k);
    result *= std::max(0.0, static_cast<double>(inliers) - taken) / (static_cast<double>(pool) - taken);
  }
  return result;
}

void StoppingRule::setLoss(double loss, std::uint64_t drawn) {
  if (epochs_.back().begin == drawn) {
    epochs_.back().loss = loss;
  } else {
    epochs_.push_back({loss, drawn});
  }
  update();
}

void StoppingRule::setInliers(std::size_t inliers) {
  all_inliers_ = probability(inliers, matches_);
  prefix_ = 0;
  update();
}

void StoppingRule::setPrefix(std::size_t inliers, std::size_t pool) {
  prefix_ = std::max(prefix_, probability(inliers, pool));
  update();
}

void StoppingRule::update() {
  const double hit = std::max(all_inliers_, prefix_);
  if (hit >= 1 && !std::isinf(log_failure_)) {
    needed_ = 0;
    return;
  }
  double left = log_failure_;
  for (std::size_t i = 0; i + 1 < epochs_.size(); ++i) {
    left -= static_cast<double>(epochs_[i + 1].begin - epochs_[i].begin) *
            std::log1p(-hit * (1 - epochs_[i].loss));
  }
  const double per_sample = std::log1p(-hit * (1 - epochs_.back().loss));
  const auto begin = static_cast<double>(epochs_.back().begin);
  needed_ = left >= 0        ? begin
            : per_sample < 0 ? begin + left / per_sample
                             : std::numeric_limits<double>::infinity();
}

MatchShare bestPrefix(const std::vector<std::uint32_t>& best_first, const std::vector<float>& errors,
                      float squared_threshold, const std::vector<std::uint8_t>& counts,
                      const ModelTraits& model, std::uint32_t pool_of_all) {
  constexpr std::size_t kMinLength = 20;
  constexpr double kChance = 0.05, kSquaredQuantile = 2.706;
  const auto m = static_cast<std::size_t>(model.sample_size);
  const auto share = static_cast<std::size_t>(model.min_prefix * static_cast<double>(best_first.size()));
  const std::size_t min_length = std::max<std::size_t>({kMinLength, pool_of_all, share});
  MatchShare best{0, 1};
  std::size_t inliers = 0, pool = 0;
  for (std::size_t i = 0; i < best_first.size(); ++i) {
    const std::uint32_t match = best_first[i];
    if (!counts.empty() && counts[match] == 0) continue;
    inliers += errors[match] <= squared_threshold ? 1 : 0;
    ++pool;
    if (i + 1 < min_length || inliers * best.pool <= best.inliers * pool) continue;
    const double mean = kChance * static_cast<double>(pool - m);
    const double enough = static_cast<double>(m) + mean + std::sqrt(kSquaredQuantile * mean * (1 - kChance));
    if (static_cast<double>(inliers) >= enough) best = {inliers, pool};
  }
  return best;
}

double samplesForMinSignificance(const NormalizedMatches& matches, const Model& model, double confidence) {
  constexpr double kTests = 8e4;  // hypotheses times thresholds, as in SignificanceTest
  constexpr double kMaxLoss = 1.0 / 8;
  if (confidence >= 1) return std::numeric_limits<double>::infinity();
  const std::size_t n = matches.size(), m = static_cast<std::size_t>(model.traits.sample_size);
  const auto [width, height] = rightExtent(matches);
  const double chance =
      std::min(1.0, model.chanceWithinOnePixel(width / matches.scale, height / matches.scale));
  std::size_t support = m + 1;
  while (support < n && std::log10(kTests) + log10BinomialTail(n - m, support - m, chance) > 0) ++support;
  double all_inliers = 1;
  for (std::size_t k = 0; k < m; ++k)
    all_inliers *= static_cast<double>(support - k) / static_cast<double>(n - k);
  return std::max(kMinSignificanceSamples,
                  std::log1p(-confidence) / std::log1p(-all_inliers * (1 - kMaxLoss)));
}

double minTestedRatio(int max_iterations, bool finds_rarer, int sample_size) {
  constexpr double kLogMissed = -6.9078, kSamplesOfRarer = 1e6, kAgreeing = 0.3;
  const double samples = finds_rarer ? std::max<double>(max_iterations, kSamplesOfRarer) : max_iterations;
  const double all_inliers = -std::expm1(kLogMissed / samples);
  return kAgreeing * std::pow(all_inliers, 1.0 / sample_size);
}

}  // namespace corrsel::core
