#include "points/distinct_matches.h"

#include <algorithm>

namespace corrsel::core {
namespace {

using Key = std::array<float, 8>;  // left x, y, right x, y, map

Key keyOf(const Correspondences& matches, const std::vector<LinearMap>& maps, std::uint32_t row) {
  const LinearMap map = maps.empty() ? LinearMap{} : maps[row];
  return {matches.left_x[row],
          matches.left_y[row],
          matches.right_x[row],
          matches.right_y[row],
          map[0],
          map[1],
          map[2],
          map[3]};
}

}  // namespace

void DistinctMatches::assign(const Correspondences& matches, const std::vector<LinearMap>& maps,
                             const std::vector<std::uint32_t>& rows) {
  order_ = rows;
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (matches.left_x[a] != matches.left_x[b]) return matches.left_x[a] < matches.left_x[b];
    const Key key_a = keyOf(matches, maps, a), key_b = keyOf(matches, maps, b);
    return key_a != key_b ? key_a < key_b : a < b;
  });
  multiplicity_.clear();
  first_row_.clear();
  of_row_.assign(matches.size(), kNone);
  for (const std::uint32_t row : order_) {
    if (first_row_.empty() || keyOf(matches, maps, row) != keyOf(matches, maps, first_row_.back())) {
      first_row_.push_back(row);
      multiplicity_.push_back(0);
    }
    ++multiplicity_.back();
    of_row_[row] = static_cast<std::uint32_t>(size() - 1);
  }
  const std::size_t length = paddedSize();
  values_.assign(kColumns * length, 0);
  for (std::size_t i = 0; i < size(); ++i) {
    const Key key = keyOf(matches, maps, first_row_[i]);
    for (std::size_t column = 0; column < kColumns; ++column) values_[column * length + i] = key[column];
  }
}

std::size_t DistinctMatches::paddedSize() const {
  return (size() + PairBlock::kColumns - 1) / PairBlock::kColumns * PairBlock::kColumns;
}

PairColumns DistinctMatches::view(const std::vector<float>& values, std::size_t length) {
  const float* const p = values.data();
  return {p,
          p + length,
          p + 2 * length,
          p + 3 * length,
          p + 4 * length,
          p + 5 * length,
          p + 6 * length,
          p + 7 * length,
          length};
}

PairColumns DistinctMatches::columns() const { return view(values_, paddedSize()); }

PairColumns DistinctMatches::columns(const std::vector<std::uint32_t>& order) {
  const std::size_t length = paddedSize();
  ordered_.assign(kColumns * length, 0);
  for (std::size_t column = 0; column < kColumns; ++column) {
    for (std::size_t i = 0; i < order.size(); ++i)
      ordered_[column * length + i] = values_[column * length + order[i]];
  }
  return view(ordered_, length);
}

}  // namespace corrsel::core
