#include "search/ordering.h"

#include <limits>

#include "corrsel/random.h"

namespace corrsel::core {
namespace {

/// Converts a distance to a sort key. Larger is worse; NaN and negative distances come last.
std::uint32_t qualityKey(float quality) {
  return quality >= 0 ? sortKey(quality) : std::numeric_limits<std::uint32_t>::max();
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
  if (m.distance.empty()) return false;
  const bool ratio = !m.second_distance.empty();
  items_.resize(rows.size());
  bool any = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const float first = m.distance[rows[i]];
    const float quality = ratio ? first / m.second_distance[rows[i]] : first;
    any = any || quality >= 0;
    items_[i] = {qualityKey(quality), static_cast<std::uint32_t>(i)};
  }
  if (!any) return false;
  radixSort(items_, scratch_);
  positions.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) positions[i] = items_[i].row;
  return true;
}

}  // namespace corrsel::core
