#include "search/stopping.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace corrsel::core
