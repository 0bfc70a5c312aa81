#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"
#include "corrsel/neighbours.h"
#include "corrsel/selection.h"

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

  /// Returns whether neighbourhoods can be formed. Otherwise sets status and message: fewer than `needed`
  /// matches give kTooFew, and points of an image that are all equal give kDegenerate.
  /// @param who  name of the selector
  bool canForm(std::size_t needed, const std::string& who, Selection& result) const;

  /// What becomes of a match that is near itself.
  enum class Self : std::uint8_t {
    kLeaveOut,     ///< it is not listed
    kDropNearest,  ///< the nearest member is not listed, which is another one where the match is no member or
                   ///< shares its point
    kKeep          ///< it is listed where it is a member
  };

  /// Finds the `listed` nearest members of all matches in both images.
  /// @param members  ascending numbers; nullptr = all
  /// @pre listed is below PointGrid::kMaxNeighbours, and there are at least listed + 1 members
  /// O(N) for evenly spread points.
  void find(const std::vector<std::uint32_t>* members, int listed, Self self);

  /// The same for the left image only.
  void findLeft(const std::vector<std::uint32_t>* members, int listed, Self self);

  /// The lists, nearest first: those of match i begin at left() + i * stride().
  const std::uint32_t* left() const { return near_left_.data() + offset_; }
  const std::uint32_t* right() const { return near_right_.data() + offset_; }
  std::size_t stride() const { return stride_; }

 private:
  void findIn(const std::vector<float>& x, const std::vector<float>& y,
              const std::vector<std::uint32_t>* members, int listed, Self self,
              std::vector<std::uint32_t>& lists);

  std::vector<std::uint32_t> of_row_, row_;
  std::vector<KeyedRow> rows_, scratch_;
  PlanarNeighbours index_;
  std::vector<std::uint32_t> near_left_, near_right_;
  std::size_t stride_ = 1, offset_ = 0;
};

}  // namespace corrsel::core
