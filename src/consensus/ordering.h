#pragma once

#include <cstdint>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Orders of the matches that depend on what the matches are, not on where they stand in the input: the same
/// set of matches gets the same answer in whatever order it comes. Keeps its memory between calls.
class Ordering {
 public:
  /// Writes all rows in random order: sorted by their coordinates first (which no shift and no change of unit
  /// alters), then shuffled by the seed, so that any stretch of them is a fair sample. O(N), O(N log N) where
  /// most matches share their left x.
  void shuffle(const Correspondences& matches, std::uint64_t seed, std::vector<std::uint32_t>& rows);

  /// Writes the positions in `rows`, best first, by descriptor distance over second-nearest distance, or by
  /// distance alone where there is no second; matches without either come last. Ties stay in the order of
  /// `rows`. O(N).
  /// @return false, nothing written, where no match has a distance
  bool byQuality(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                 std::vector<std::uint32_t>& positions);

 private:
  std::vector<KeyedRow> items_, scratch_;
};

}  // namespace corrsel::core
