#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Counts the distinct places of matches.
///
/// Idea: detectors find one corner several times, at several scales and orientations, and many left features
/// may share one right feature. Such matches agree with a wrong model all at once, and are evidence only
/// once.
///
/// Algorithm: the number of cells of 8 px that hold a match, the smaller one of both images.
///
/// Cost: O(k log k) for k matches; memory is kept between calls.
class OccupiedCells {
 public:
  /// @param mask  as long as `matches`; not 0 for the matches to count
  std::size_t count(const Correspondences& matches, const std::vector<std::uint8_t>& mask);

 private:
  std::size_t count(const std::vector<float>& x, const std::vector<float>& y,
                    const std::vector<std::uint8_t>& mask);

  std::vector<std::uint64_t> cells_;
};

}  // namespace corrsel::core
