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

unsigned bitWidth(std::uint64_t value) {
  unsigned width = 0;
  while (width < 64 && value >> width != 0) ++width;
  return width;
}

constexpr unsigned kMaxBits = 11;
constexpr std::size_t kBlock = 256;  // rows whose digits are known at a time

/// How a key is divided into digits, the lowest first.
struct Digits {
  std::uint32_t lowest;  // key
  unsigned ignored;      // lowest bits of key - lowest
  unsigned bits;         // of a digit

  /// Writes one digit of up to kBlock rows.
  void read(const KeyedRow* rows, std::size_t count, unsigned round, std::uint32_t* out) const {
    const unsigned shift = ignored + round * bits;
    const std::uint32_t first = lowest, mask = (1U << bits) - 1;  // which `out` cannot change
    for (std::size_t k = 0; k < count; ++k) out[k] = (rows[k].key - first) >> shift & mask;
  }
};

/// Sorts by the digits and keeps the order of rows whose digits are equal.
template <unsigned rounds>
void sortByDigits(const Digits& digits, std::vector<KeyedRow>& rows, std::vector<KeyedRow>& scratch) {
  const std::size_t n = rows.size(), buckets = std::size_t{1} << digits.bits;
  std::array<std::array<std::uint32_t, 1U << kMaxBits>, rounds> starts;
  for (auto& of_round : starts) std::fill_n(of_round.begin(), buckets, 0U);
  // Digits, places and rows have loops of their own. The processor cannot rule out that a write changes what
  // the next row reads, unless it knows the addresses of both early.
  std::array<std::array<std::uint32_t, kBlock>, rounds> digit;
  std::array<std::uint32_t, kBlock> places;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    for (unsigned round = 0; round < rounds; ++round)
      digits.read(rows.data() + begin, count, round, digit[round].data());
    for (std::size_t k = 0; k < count; ++k) {
      for (unsigned round = 0; round < rounds; ++round) ++starts[round][digit[round][k]];
    }
  }
  scratch.resize(n);
  for (unsigned round = 0; round < rounds; ++round) {
    std::uint32_t total = 0;
    for (std::size_t bucket = 0; bucket < buckets; ++bucket)
      total += std::exchange(starts[round][bucket], total);
    for (std::size_t begin = 0; begin < n; begin += kBlock) {
      const std::size_t count = std::min(kBlock, n - begin);
      const KeyedRow* const block = rows.data() + begin;
      digits.read(block, count, round, digit[round].data());
      for (std::size_t k = 0; k < count; ++k) places[k] = starts[round][digit[round][k]]++;
      for (std::size_t k = 0; k < count; ++k) scratch[places[k]] = block[k];
    }
    rows.swap(scratch);
  }
}

/// Sorts rows of which few are out of order, and keeps the order of equal keys. Returns false and leaves the
/// rest if that would take more steps than there are rows.
bool insertMisplaced(std::vector<KeyedRow>& rows) {
  std::size_t steps = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i - 1].key <= rows[i].key) continue;
    const KeyedRow row = rows[i];
    std::size_t place = i;
    for (; place > 0 && rows[place - 1].key > row.key && steps < rows.size(); --place, ++steps)
      rows[place] = rows[place - 1];
    rows[place] = row;
    if (steps == rows.size()) return false;
  }
  return true;
}

}  // namespace

void radixSort(std::vector<KeyedRow>& rows, std::vector<KeyedRow>& scratch) {
  constexpr unsigned kMinBits = 8;
  constexpr std::size_t kMany = std::size_t{1} << 18;
  if (rows.empty()) return;
  std::uint32_t lowest = rows.front().key, highest = lowest;
  for (const KeyedRow& row : rows) {
    lowest = std::min(lowest, row.key);
    highest = std::max(highest, row.key);
  }
  // Two rounds over the upper bits leave few rows out of order, unless there are very many rows or their keys
  // lie in clusters. Few rows do not repay many buckets.
  if (rows.size() < kMany) {
    const unsigned bits = std::clamp(bitWidth(rows.size() / 8), kMinBits, kMaxBits);
    const unsigned width = bitWidth(highest - lowest);
    sortByDigits<2>({lowest, width > 2 * bits ? width - 2 * bits : 0, bits}, rows, scratch);
    if (insertMisplaced(rows)) return;
  }
  sortByDigits<3>({lowest, 0, kMaxBits}, rows, scratch);
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
