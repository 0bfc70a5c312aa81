#include "points/match_neighbours.h"

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

bool MatchNeighbours::canForm(std::size_t needed, const std::string& who, Selection& result) const {
  if (size() < needed) {
    result.status = Status::kTooFew;
    result.message =
        std::to_string(size()) + " distinct matches, " + who + " needs " + std::to_string(needed);
    return false;
  }
  if (allEqual(left_x, left_y) || allEqual(right_x, right_y)) {
    result.status = Status::kDegenerate;
    result.message = "all points of one image are equal: neighbourhoods have no meaning";
    return false;
  }
  return true;
}

void MatchNeighbours::findIn(const std::vector<float>& x, const std::vector<float>& y,
                             const std::vector<std::uint32_t>* members, int listed, Self self,
                             std::vector<std::uint32_t>& lists) {
  constexpr std::size_t kBeyond = 8;  // numbers that a kernel may read behind the end
  const std::size_t n = size(), count = members != nullptr ? members->size() : n;
  const int k = self == Self::kKeep ? listed : listed + 1;
  stride_ = static_cast<std::size_t>(k);
  offset_ = self == Self::kKeep ? 0 : 1;
  lists.resize(n * stride_ + kBeyond);
  // Matches are numbered by x, cells along their first coordinate. With x and y exchanged both orders agree,
  // which keeps what is used together in the processor's cache.
  index_.build(y.data(), x.data(), count, k, members != nullptr ? members->data() : nullptr);
  index_.nearestToAll(y.data(), x.data(), n, k, lists.data());
  if (self == Self::kLeaveOut) takeOutSelf(lists, n, stride_);
}

void MatchNeighbours::find(const std::vector<std::uint32_t>* members, int listed, Self self) {
  findIn(left_x, left_y, members, listed, self, near_left_);
  findIn(right_x, right_y, members, listed, self, near_right_);
}

void MatchNeighbours::findLeft(const std::vector<std::uint32_t>* members, int listed, Self self) {
  findIn(left_x, left_y, members, listed, self, near_left_);
}

}  // namespace corrsel::core
