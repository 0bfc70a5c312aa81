#include "search/ordering.h"

#include <limits>

#include "base/match_costs.h"
#include "corrsel/random.h"

namespace corrsel::core {
namespace {

/// Converts a cost to a sort key. Larger is worse; NaN and negative costs come last.
std::uint32_t costKey(float cost) {
  return cost >= 0 ? sortKey(cost) : std::numeric_limits<std::uint32_t>::max();
}

}  // namespace

void Ordering::shuffle(const Correspondences& m, std::uint64_t seed, std::vector<std::uint32_t>& rows) {
  const std::size_t n = m.size();
  sortByCoordinates(m, items_, scratch_);
  rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) rows[i] = items_[i].row;
  Random(seed).shuffle(rows);
}

bool Ordering::byQuality(const Correspondences& m, const std::vector<std::uint32_t>& rows,
                         std::vector<std::uint32_t>& positions) {
  const MatchCosts costs(m);
  if (!costs.known()) return false;
  items_.resize(rows.size());
  bool any = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const float cost = costs.ratio(rows[i]);
    any = any || cost >= 0;
    items_[i] = {costKey(cost), static_cast<std::uint32_t>(i)};
  }
  if (!any) return false;
  radixSort(items_, scratch_);
  positions.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) positions[i] = items_[i].row;
  return true;
}

}  // namespace corrsel::core
