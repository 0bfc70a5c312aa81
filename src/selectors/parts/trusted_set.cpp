#include "selectors/parts/trusted_set.h"

#include <algorithm>
#include <cmath>

#include "base/coordinate_order.h"

namespace corrsel::core {

std::string TrustedSet::missingInput(const Correspondences& matches, const char* who) {
  if (matches.empty() || (!matches.distance.empty() && !matches.second_distance.empty())) return "";
  return std::string(who) + " needs the column " +
         (matches.distance.empty() ? "distance" : "second_distance");
}

void TrustedSet::find(const Correspondences& matches, double max_ratio) {
  rows_.clear();
  ratio_.clear();
  x_.clear();
  y_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    const double first = matches.distance[i], second = matches.second_distance[i];
    // Comparisons with NaN are false.
    if (!(first >= 0 && second > 0 && std::isfinite(second) && first < max_ratio * second)) continue;
    rows_.push_back(i);
    ratio_.push_back(static_cast<float>(first / second));
    x_.push_back(matches.right_x[i]);
    y_.push_back(matches.right_y[i]);
  }
  right_points_.number(x_, y_, 1);
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  const auto better = [&](std::uint32_t a, std::uint32_t b) {
    if (ratio_[a] != ratio_[b]) return ratio_[a] < ratio_[b];
    return compareCoordinates(matches, rows_[a], rows_[b]) < 0;
  };
  best_.assign(right_points_.sizes.size(), kNone);
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    std::uint32_t& best = best_[right_points_.of[k]];
    if (best == kNone || better(k, best)) best = k;
  }
  mask_.assign(matches.size(), 0);
  for (const std::uint32_t k : best_) mask_[rows_[k]] = 1;
}

}  // namespace corrsel::core
