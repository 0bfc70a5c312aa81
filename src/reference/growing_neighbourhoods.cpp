#include "reference/growing_neighbourhoods.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {
namespace {

/// The cell of a level: each dimension has half as many cells as on the level before.
std::uint32_t cellOf(std::uint32_t finest, int level) {
  std::uint32_t cell = 0;
  const int bits = 4 - level;
  for (int dimension = 0; dimension < 4; ++dimension)
    cell = cell << bits | ((finest >> (4 * dimension) & 15U) >> level);
  return cell;
}

}  // namespace

void GrowingNeighbourhoods::growth(std::size_t count, int sample_size, double samples,
                                   std::vector<std::uint64_t>& result) {
  const auto others = static_cast<std::size_t>(sample_size - 1);
  double expected = samples;
  for (std::size_t i = 0; i < others; ++i)
    expected *= static_cast<double>(others - i) / static_cast<double>(count - i);
  result.assign(count, 1);
  for (std::size_t n = others + 1; n <= count; ++n) {
    const double next = expected * static_cast<double>(n) / static_cast<double>(n - others);
    result[n - 1] = result[n - 2] + static_cast<std::uint64_t>(std::ceil(next - expected));
    expected = next;
  }
}

void GrowingNeighbourhoods::build(const NormalizedMatches& matches,
                                  const std::vector<std::uint32_t>& best_first, int sample_size) {
  constexpr float kCells = 16;
  const std::size_t n = best_first.size();
  best_first_ = &best_first;
  sample_size_ = static_cast<std::size_t>(sample_size);
  growth(n, sample_size, static_cast<double>(n / 2), growth_);
  hits_.assign(n, 0);
  size_.assign(n, static_cast<std::uint32_t>(sample_size));
  cell_.assign(n, 0);
  for (const auto* column : {&matches.left_x, &matches.left_y, &matches.right_x, &matches.right_y}) {
    const auto [smallest, largest] = std::minmax_element(column->begin(), column->end());
    const float width = std::max(*largest - *smallest, 1e-30F);
    for (std::size_t rank = 0; rank < n; ++rank) {
      const float part = ((*column)[best_first[rank]] - *smallest) / width;
      // NaN where the width is infinite.
      const auto cell = part > 0 ? static_cast<std::uint32_t>(std::min(part * kCells, kCells - 1)) : 0U;
      cell_[rank] = static_cast<std::uint16_t>(cell_[rank] << 4 | cell);
    }
  }
  for (int level = 0; level < kLevels; ++level) {
    std::vector<std::uint32_t>&begins = begins_[level], &members = members_[level];
    begins.assign((std::size_t{1} << (4 * (4 - level))) + 1, 0);
    for (const std::uint16_t cell : cell_) ++begins[cellOf(cell, level) + 1];
    for (std::size_t c = 1; c < begins.size(); ++c) begins[c] += begins[c - 1];
    members.resize(n);
    for (std::uint32_t rank = 0; rank < n; ++rank) members[begins[cellOf(cell_[rank], level)]++] = rank;
    // Every entry is now the end of its cell, which is the begin of the next one.
    std::copy_backward(begins.begin(), begins.end() - 1, begins.end());
    begins[0] = 0;
  }
}

bool GrowingNeighbourhoods::draw(Random& random, std::uint32_t centre, std::uint32_t* sample) {
  const std::size_t n = hits_.size(), m = sample_size_;
  ++hits_[centre];
  std::uint32_t& size = size_[centre];
  while (hits_[centre] > growth_[size - 1] && size < n) ++size;
  for (int level = 0; level < kLevels; ++level) {
    const std::uint32_t cell = cellOf(cell_[centre], level);
    const auto first = members_[level].begin() + begins_[level][cell];
    const auto end = members_[level].begin() + begins_[level][cell + 1];
    if (static_cast<std::size_t>(end - first) < size) continue;
    // The neighbours without the centre.
    const auto position = static_cast<std::uint32_t>(std::lower_bound(first, end, centre) - first);
    const auto neighbour = [&](std::uint32_t k) { return first[k < position ? k : k + 1]; };
    std::uint32_t ranks[8];
    random.sample(size - 2, m - 2, ranks);
    for (std::size_t k = 0; k < m - 2; ++k) ranks[k] = neighbour(ranks[k]);
    ranks[m - 2] = neighbour(size - 2);
    for (std::size_t k = 0; k + 1 < m; ++k) ++hits_[ranks[k]];
    ranks[m - 1] = centre;
    for (std::size_t k = 0; k < m; ++k) sample[k] = (*best_first_)[ranks[k]];
    return true;
  }
  return false;
}

}  // namespace corrsel::core
