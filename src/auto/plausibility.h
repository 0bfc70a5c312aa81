#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/neighbours.h"
#include "points/distinct_matches.h"

namespace corrsel::core {

/// Removes matches that agree with a fundamental matrix but not with their surroundings.
///
/// Idea: an outlier agrees with the epipolar geometry by chance if its right point lies near its epipolar
/// line, anywhere along it. The local maps of inliers nearby tell roughly where on the line it belongs.
///
/// Algorithm: a match outside the core stays if at least 2 of its 8 nearest core matches in the left image
/// predict its right point within max(10 units (length_unit.h), 0.6 |A dx|), where A is the linear part of
/// the local map of the core match and dx the displacement from it.
///
/// Cost: O(N) time, memory is kept between calls.
class Plausibility {
 public:
  /// @param matches  N matches
  /// @param maps     linear parts of their local maps
  /// @param core     per match: 1 = trusted; these stay. With fewer than 2 of them nothing is removed.
  /// @param mask     per match: 1 = to be tested if it is not in the core; 0 is written where the test fails
  void filter(const Correspondences& matches, const std::vector<LinearMap>& maps,
              const std::vector<std::uint8_t>& core, std::vector<std::uint8_t>& mask);

 private:
  std::vector<std::uint32_t> members_;
  PlanarNeighbours neighbours_;
};

}  // namespace corrsel::core
