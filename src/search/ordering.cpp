#include "search/ordering.h"

#include <limits>

#include "base/match_costs.h"
#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();

/// Converts a cost to a sort key. Larger is worse; NaN and negative costs come last.
std::uint32_t costKey(float cost) { return sortKey(cost) | (cost >= 0 ? 0U : kUnknown); }

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
  costs.ratios(costs_);
  items_.resize(rows.size());
  std::uint32_t common = kUnknown;  // bits of all keys
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::uint32_t key = costKey(costs_[rows[i]]);
    common &= key;
    items_[i] = {key, static_cast<std::uint32_t>(i)};
  }
  if (common == kUnknown) return false;
  radixSort(items_, scratch_);
  positions.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) positions[i] = items_[i].row;
  return true;
}

}  // namespace corrsel::core
