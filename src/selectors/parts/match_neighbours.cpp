#include "selectors/parts/match_neighbours.h"

#include <algorithm>

namespace corrsel::core {
namespace {

/// Moves every list so that its neighbours, the match itself taken out, stand at 1 and behind.
void takeOutSelf(std::vector<std::uint32_t>& lists, std::size_t count, std::size_t length) {
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t* const list = lists.data() + i * length;
    std::uint32_t* const end = std::find(list, list + length - 1, static_cast<std::uint32_t>(i));
    std::move_backward(list, end, end + 1);
  }
}

}  // namespace

void MatchNeighbours::assign(const Correspondences& matches, bool merge,
                             const std::vector<std::uint8_t>* mask) {
  const std::size_t n = matches.size();
  sortByCoordinates(matches, rows_, scratch_);
  std::vector<float>* const columns[] = {&left_x, &left_y, &right_x, &right_y};
  for (std::vector<float>* const column : columns) column->resize(n);
  of_row_.resize(n);
  row_.resize(n);
  std::uint32_t distinct = 0;
  for (const KeyedRow& sorted : rows_) {
    const std::uint32_t row = sorted.row;
    of_row_[row] = kNone;
    if (mask != nullptr && (*mask)[row] == 0) continue;
    const bool repeated = merge && distinct > 0 && compareCoordinates(matches, row_[distinct - 1], row) == 0;
    if (!repeated) {
      left_x[distinct] = matches.left_x[row];
      left_y[distinct] = matches.left_y[row];
      right_x[distinct] = matches.right_x[row];
      right_y[distinct] = matches.right_y[row];
      row_[distinct++] = row;
    }
    of_row_[row] = distinct - 1;
  }
  for (std::vector<float>* const column : columns) column->resize(distinct);
}

void MatchNeighbours::find(const std::vector<std::uint32_t>* members, int listed, bool compat) {
  const std::size_t n = size();
  const std::size_t count = members != nullptr ? members->size() : n;
  const std::uint32_t* const numbers = members != nullptr ? members->data() : nullptr;
  constexpr std::size_t kBeyond = 8;  // numbers that a kernel may read behind the end
  stride_ = static_cast<std::size_t>(listed) + 1;
  near_left_.resize(n * stride_ + kBeyond);
  near_right_.resize(n * stride_ + kBeyond);
  // Matches are numbered by x, cells along their first coordinate. With x and y exchanged both orders agree,
  // which keeps what is used together in the processor's cache.
  const int k = listed + 1;
  left_.build(left_y.data(), left_x.data(), count, k, numbers);
  left_.nearestToAll(left_y.data(), left_x.data(), n, k, near_left_.data());
  right_.build(right_y.data(), right_x.data(), count, k, numbers);
  right_.nearestToAll(right_y.data(), right_x.data(), n, k, near_right_.data());
  if (compat) return;  // the first neighbour is left out even where it is not the match itself
  takeOutSelf(near_left_, n, stride_);
  takeOutSelf(near_right_, n, stride_);
}

}  // namespace corrsel::core
