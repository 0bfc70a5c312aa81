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
  constexpr unsigned kBits = 11, kRounds = 3;
  constexpr std::uint32_t kBuckets = 1U << kBits;
  std::array<std::array<std::uint32_t, kBuckets>, kRounds> starts{};
  const auto digit = [](std::uint32_t key, unsigned round) {
    return key >> (round * kBits) & (kBuckets - 1);
  };
  for (const KeyedRow& row : rows) {
    for (unsigned round = 0; round < kRounds; ++round) ++starts[round][digit(row.key, round)];
  }
  scratch.resize(rows.size());
  for (unsigned round = 0; round < kRounds; ++round) {
    std::uint32_t total = 0;
    for (std::uint32_t& start : starts[round]) total += std::exchange(start, total);
    for (const KeyedRow& row : rows) scratch[starts[round][digit(row.key, round)]++] = row;
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
    return order != 0 ? order < 0 : a.row < b.row;
  };
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    while (end < n && rows[end].key == rows[begin].key) ++end;
    if (end - begin > 1) {
      std::sort(rows.begin() + static_cast<std::ptrdiff_t>(begin),
                rows.begin() + static_cast<std::ptrdiff_t>(end), less);
    }
  }
}

}  // namespace corrsel::core
