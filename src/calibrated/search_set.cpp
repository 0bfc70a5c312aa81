#include "calibrated/search_set.h"

#include <limits>

#include "base/gather.h"
#include "base/match_costs.h"

namespace corrsel::core {
namespace {

constexpr double kPlace = 1e-3;  // px: points that differ by less are one
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Whether a cost is better; unknown ones are the worst.
bool isBetter(float a, float b) { return a < b || (b != b && a == a); }

}  // namespace

const std::vector<std::uint32_t>& SearchSet::choose(const Correspondences& matches,
                                                    const std::vector<std::uint32_t>& rows) {
  rows_ = rows;
  const MatchCosts costs(matches);
  costs_.resize(costs.known() ? matches.size() : 0);
  for (std::uint32_t i = 0; i < costs_.size(); ++i) costs_[i] = costs.nearest(i);
  keepBest(matches.right_x, matches.right_y);
  if (costs.known()) costs.ratios(costs_);
  keepBest(matches.left_x, matches.left_y);
  return rows_;
}

/// Keeps of all rows that share a point the one of the least cost.
void SearchSet::keepBest(const std::vector<float>& x, const std::vector<float>& y) {
  gather(x, rows_, x_);
  gather(y, rows_, y_);
  groups_.number(x_, y_, kPlace);
  best_.assign(groups_.sizes.size(), kNone);
  for (std::uint32_t i = 0; i < rows_.size(); ++i) {
    std::uint32_t& best = best_[groups_.of[i]];
    if (best == kNone || (!costs_.empty() && isBetter(costs_[rows_[i]], costs_[rows_[best]]))) best = i;
  }
  std::size_t kept = 0;
  for (std::uint32_t i = 0; i < rows_.size(); ++i)
    if (best_[groups_.of[i]] == i) rows_[kept++] = rows_[i];
  rows_.resize(kept);
}

}  // namespace corrsel::core
