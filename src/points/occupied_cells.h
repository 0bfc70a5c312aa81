#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "points/point_groups.h"

namespace corrsel::core {

/// Counts the distinct places of matches, because matches that repeat one another agree with a bad model
/// all at once.
///
/// Algorithm: the number of cells of 8 units of the image (length_unit.h), at least 8 px, that hold a match,
/// the smaller one of both images.
///
/// Cost: O(N) for a mask of N matches; memory is kept between calls.
class OccupiedCells {
 public:
  /// @param mask  as long as `matches`; not 0 for the matches to count
  std::size_t count(const Correspondences& matches, const std::vector<std::uint8_t>& mask);

 private:
  std::size_t count(const std::vector<float>& x, const std::vector<float>& y, double unit,
                    const std::vector<std::uint8_t>& mask);

  std::vector<float> x_, y_;  // of the matches to count
  PointGroups groups_;
};

}  // namespace corrsel::core
