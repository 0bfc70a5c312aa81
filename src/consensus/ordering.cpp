#include "corrsel/consensus/ordering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>

namespace corrsel::core {
namespace {

std::uint32_t bitsOf(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

/// The finisher of splitmix64.
std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
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
  const std::uint64_t salt = mix(seed + 0x9e3779b97f4a7c15ULL);
  for (std::size_t i = 0; i < n; ++i) {
    // Adding 0 turns -0 into 0, which is the same place.
    const std::uint64_t left = (std::uint64_t{bitsOf(m.left_x[i] + 0.0F)} << 32) | bitsOf(m.left_y[i] + 0.0F);
    const std::uint64_t right =
        (std::uint64_t{bitsOf(m.right_x[i] + 0.0F)} << 32) | bitsOf(m.right_y[i] + 0.0F);
    items_[i] = {static_cast<std::uint32_t>(mix(mix(left ^ salt) + right) >> 32),
                 static_cast<std::uint32_t>(i)};
  }
  sortItems();
  const auto place = [&m](std::uint32_t i) {
    const auto at = [i](const std::vector<float>& column) {
      return column.empty() ? 0U : qualityKey(column[i]);
    };
    return std::make_tuple(m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i], at(m.distance),
                           at(m.second_distance));
  };
  for (std::size_t begin = 0; begin < n;) {
    std::size_t end = begin + 1;
    while (end < n && items_[end].first == items_[begin].first) ++end;
    if (end - begin > 1) {
      std::sort(items_.begin() + static_cast<std::ptrdiff_t>(begin),
                items_.begin() + static_cast<std::ptrdiff_t>(end),
                [&place](const Item& a, const Item& b) { return place(a.second) < place(b.second); });
    }
    begin = end;
  }
  rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) rows[i] = items_[i].second;
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
