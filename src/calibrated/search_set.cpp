#include "calibrated/search_set.h"

#include <limits>

#include "base/gather.h"

namespace corrsel::core {
namespace {

constexpr double kPlace = 1e-3;  // px: points that differ by less are one
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Whether a quality is better; unknown ones are the worst.
bool isBetter(float a, float b) { return a < b || (b != b && a == a); }

}  // namespace

const std::vector<std::uint32_t>& SearchSet::choose(const Correspondences& matches,
                                                    const std::vector<std::uint32_t>& rows) {
  rows_ = rows;
  quality_ = matches.distance;
  keepBest(matches.right_x, matches.right_y, quality_);
  if (matches.second_distance.size() == quality_.size())
    for (std::size_t i = 0; i < quality_.size(); ++i) quality_[i] /= matches.second_distance[i];
  keepBest(matches.left_x, matches.left_y, quality_);
  return rows_;
}

/// Keeps of all rows that share a point the one of the best quality.
void SearchSet::keepBest(const std::vector<float>& x, const std::vector<float>& y,
                         const std::vector<float>& quality) {
  gather(x, rows_, x_);
  gather(y, rows_, y_);
  groups_.number(x_, y_, kPlace);
  best_.assign(groups_.sizes.size(), kNone);
  for (std::uint32_t i = 0; i < rows_.size(); ++i) {
    std::uint32_t& best = best_[groups_.of[i]];
    if (best == kNone || (!quality.empty() && isBetter(quality[rows_[i]], quality[rows_[best]]))) best = i;
  }
  std::size_t kept = 0;
  for (std::uint32_t i = 0; i < rows_.size(); ++i)
    if (best_[groups_.of[i]] == i) rows_[kept++] = rows_[i];
  rows_.resize(kept);
}

}  // namespace corrsel::core
