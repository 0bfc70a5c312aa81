#include "corrsel/consensus/ordering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>

#include "corrsel/random.h"

namespace corrsel::core {
namespace {

std::uint32_t bitsOf(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

/// A number that grows with the value.
std::uint32_t sortKey(float value) {
  const std::uint32_t bits = bitsOf(value + 0.0F);  // -0 becomes 0, which is the same place
  return bits & 0x80000000U ? ~bits : bits | 0x80000000U;
}

/// A distance as a key: larger is worse, NaN and negative ones worst of all.
std::uint32_t qualityKey(float quality) {
  return quality >= 0 ? bitsOf(quality + 0.0F) : std::numeric_limits<std::uint32_t>::max();
}

}  // namespace

/// Stable radix sort by key.
void Ordering::sortItems() {
  constexpr int kBits = 11, kPasses = 3;
  constexpr std::size_t kBuckets = std::size_t{1} << kBits;
  std::array<std::array<std::uint32_t, kBuckets>, kPasses> starts{};
  for (const Item& item : items_) {
    for (int pass = 0; pass < kPasses; ++pass)
      ++starts[static_cast<std::size_t>(pass)][(item.first >> (pass * kBits)) & (kBuckets - 1)];
  }
  scratch_.resize(items_.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    auto& start = starts[static_cast<std::size_t>(pass)];
    std::uint32_t sum = 0;
    for (std::uint32_t& bucket : start) sum += std::exchange(bucket, sum);
    for (const Item& item : items_) scratch_[start[(item.first >> (pass * kBits)) & (kBuckets - 1)]++] = item;
    items_.swap(scratch_);
  }
}

void Ordering::shuffle(const Correspondences& m, std::uint64_t seed, std::vector<std::uint32_t>& rows) {
  const std::size_t n = m.size();
  items_.resize(n);
  for (std::size_t i = 0; i < n; ++i) items_[i] = {sortKey(m.left_x[i]), static_cast<std::uint32_t>(i)};
  sortItems();
  const auto rest = [&m](std::uint32_t i) {
    const auto at = [i](const std::vector<float>& column) {
      return column.empty() ? 0U : qualityKey(column[i]);
    };
    return std::make_tuple(m.left_y[i], m.right_x[i], m.right_y[i], at(m.distance), at(m.second_distance));
  };
  for (std::size_t begin = 0; begin < n;) {
    std::size_t end = begin + 1;
    while (end < n && items_[end].first == items_[begin].first) ++end;
    if (end - begin > 1) {
      std::sort(items_.begin() + static_cast<std::ptrdiff_t>(begin),
                items_.begin() + static_cast<std::ptrdiff_t>(end),
                [&rest](const Item& a, const Item& b) { return rest(a.second) < rest(b.second); });
    }
    begin = end;
  }
  rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) rows[i] = items_[i].second;
  Random random(seed);
  for (std::size_t i = n; i > 1; --i)
    std::swap(rows[i - 1], rows[random.index(static_cast<std::uint32_t>(i))]);
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
  sortItems();
  positions.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) positions[i] = items_[i].second;
  return true;
}

}  // namespace corrsel::core
