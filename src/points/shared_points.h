#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "points/point_groups.h"

namespace corrsel::core {

/// The places of one image at which there are several points.
///
/// Idea: most points are alone, and only the others need to be compared with each other.
///
/// Algorithm: a table has 16 to 32 bits per point, and each point sets the bit that a hash of its place
/// chooses. A point whose bit no other point sets is alone. PointGroups groups the remaining points, which
/// are few unless many points share their place.
class SharedPoints {
 public:
  /// Forgets the points of the previous call and keeps the memory. Two points are at one place if PointGroups
  /// gives them the same number. O(N).
  /// @param cell  in the unit of the coordinates; positive
  void find(const std::vector<float>& x, const std::vector<float>& y, double cell);

  /// One more than the largest number in `of`.
  std::uint32_t numbers() const { return static_cast<std::uint32_t>(groups_.sizes.size()) + 1; }

  std::vector<std::uint32_t> of;  ///< number of each point's place; 0 if the point is alone

 private:
  /// Bits that at least one point has set, and those that at least two have.
  struct Word {
    std::uint64_t once, twice;
  };

  template <bool exact>
  void setBits(const std::vector<float>& x, const std::vector<float>& y, float inverse_cell, unsigned bits);

  std::vector<Word> words_;
  std::vector<std::uint32_t> bits_;        // of each point
  std::vector<std::uint32_t> candidates_;  // points whose bit is set twice
  std::vector<float> x_, y_;               // of the candidates
  PointGroups groups_;                     // of the candidates
};

}  // namespace corrsel::core
