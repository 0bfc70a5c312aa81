#include "base/coordinate_order.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace corrsel::core {
namespace {

/// The same for a column that may be empty or hold NaN, which comes last.
int compareOptional(const std::vector<float>& column, std::uint32_t a, std::uint32_t b) {
  if (column.empty() || column[a] == column[b]) return 0;
  const bool known_a = column[a] == column[a], known_b = column[b] == column[b];
  if (known_a && known_b) return column[a] < column[b] ? -1 : 1;
  return static_cast<int>(known_b) - static_cast<int>(known_a);
}

}  // namespace

void radixSort(std::vector<KeyedRow>& rows, std::vector<KeyedRow>& scratch) {
  constexpr unsigned kMaxBits = 11, kRounds = 3;
  constexpr std::size_t kBlock = 256;
  if (rows.empty()) return;
  std::uint32_t lowest = rows.front().key, highest = lowest;
  for (const KeyedRow& row : rows) {
    lowest = std::min(lowest, row.key);
    highest = std::max(highest, row.key);
  }
  // Only the bits in which the keys differ are sorted. Few buckets stay in the cache.
  unsigned bits = 1;
  while (bits < kMaxBits && (highest - lowest) >> (kRounds * bits) != 0) ++bits;
  const std::uint32_t buckets = 1U << bits;
  const auto digit = [lowest, bits, buckets](std::uint32_t key, unsigned round) {
    return (key - lowest) >> (round * bits) & (buckets - 1);
  };
  std::array<std::array<std::uint32_t, 1U << kMaxBits>, kRounds> starts;
  for (auto& of_round : starts) std::fill_n(of_round.begin(), buckets, 0U);
  for (const KeyedRow& row : rows) {
    for (unsigned round = 0; round < kRounds; ++round) ++starts[round][digit(row.key, round)];
  }
  scratch.resize(rows.size());
  // A row that is written as soon as its place is known delays the next look into `starts`, because the
  // processor cannot rule out that the two overlap.
  std::array<std::uint32_t, kBlock> places;
  for (unsigned round = 0; round < kRounds; ++round) {
    std::uint32_t total = 0;
    for (std::uint32_t bucket = 0; bucket < buckets; ++bucket)
      total += std::exchange(starts[round][bucket], total);
    for (std::size_t begin = 0; begin < rows.size(); begin += kBlock) {
      const std::size_t count = std::min(kBlock, rows.size() - begin);
      const KeyedRow* const block = rows.data() + begin;
      for (std::size_t k = 0; k < count; ++k) places[k] = starts[round][digit(block[k].key, round)]++;
      for (std::size_t k = 0; k < count; ++k) scratch[places[k]] = block[k];
    }
    rows.swap(scratch);
  }
}

int compareCoordinates(const Correspondences& m, std::uint32_t a, std::uint32_t b) {
  if (m.left_x[a] != m.left_x[b]) return m.left_x[a] < m.left_x[b] ? -1 : 1;
  if (m.left_y[a] != m.left_y[b]) return m.left_y[a] < m.left_y[b] ? -1 : 1;
  if (m.right_x[a] != m.right_x[b]) return m.right_x[a] < m.right_x[b] ? -1 : 1;
  if (m.right_y[a] != m.right_y[b]) return m.right_y[a] < m.right_y[b] ? -1 : 1;
  return 0;
}

bool allEqual(const std::vector<float>& x, const std::vector<float>& y) {
  const auto differs = [](const std::vector<float>& column) {
    return std::any_of(column.begin(), column.end(), [&](float value) { return value != column.front(); });
  };
  return !differs(x) && !differs(y);
}

void sortByCoordinates(const Correspondences& matches, std::vector<KeyedRow>& rows,
                       std::vector<KeyedRow>& scratch) {
  const std::size_t n = matches.size();
  rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) rows[i] = {sortKey(matches.left_x[i]), static_cast<std::uint32_t>(i)};
  radixSort(rows, scratch);
  const auto less = [&matches](const KeyedRow& a, const KeyedRow& b) {
    int order = compareCoordinates(matches, a.row, b.row);
    if (order == 0) order = compareOptional(matches.distance, a.row, b.row);
    if (order == 0) order = compareOptional(matches.second_distance, a.row, b.row);
    if (order == 0) order = compareOptional(matches.probability, a.row, b.row);
    return order != 0 ? order < 0 : a.row < b.row;
  };
  for (std::size_t end = 1; end < n; ++end) {
    if (rows[end].key != rows[end - 1].key) continue;
    const std::size_t begin = end - 1;
    while (end < n && rows[end].key == rows[begin].key) ++end;
    std::sort(rows.begin() + static_cast<std::ptrdiff_t>(begin),
              rows.begin() + static_cast<std::ptrdiff_t>(end), less);
  }
}

}  // namespace corrsel::core
