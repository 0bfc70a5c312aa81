#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"
#include "corrsel/selectors/neighbours.h"

namespace corrsel::core {

/// The nearest matches of every match, in the left and in the right image.
///
/// Matches are numbered in the order of their coordinates, and equal distances are ordered by number. The
/// lists then do not depend on the order of the input. Memory is kept between calls.
class MatchNeighbours {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// @param merge  give matches with equal coordinates one number
  /// @param mask   the matches to take, as long as `matches`; nullptr = all
  /// O(N log N).
  void assign(const Correspondences& matches, bool merge, const std::vector<std::uint8_t>* mask = nullptr);

  /// The number of numbered matches, and their points by number.
  std::size_t size() const { return left_x.size(); }
  std::vector<float> left_x, left_y, right_x, right_y;

  /// The number of a row of the input, or kNone if it was not taken.
  std::uint32_t ofRow(std::size_t row) const { return of_row_[row]; }

  /// The first row of the input that has this number.
  std::uint32_t rowOf(std::uint32_t number) const { return row_[number]; }

  /// Finds the `listed` nearest members of all matches in both images, without the match itself.
  /// @param members  ascending numbers; nullptr = all
  /// @param compat   leave out the nearest member instead of the match itself, which differs where the match
  ///                 is no member or shares its point with another one
  /// @pre listed is below PointGrid::kMostNeighbours, and there are at least listed + 1 members
  /// O(N) for evenly spread points.
  void find(const std::vector<std::uint32_t>* members, int listed, bool compat = false);

  /// The lists of find(), nearest first: those of match i begin at left() + i * stride().
  const std::uint32_t* left() const { return near_left_.data() + 1; }
  const std::uint32_t* right() const { return near_right_.data() + 1; }
  std::size_t stride() const { return stride_; }

 private:
  std::vector<std::uint32_t> of_row_, row_;
  std::vector<KeyedRow> rows_, scratch_;
  PlanarNeighbours left_, right_;
  std::vector<std::uint32_t> near_left_, near_right_;
  std::size_t stride_ = 1;
};

}  // namespace corrsel::core
