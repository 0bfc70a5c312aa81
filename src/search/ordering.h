#pragma once

#include <cstdint>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Sorts matches by their values, so that the result of a selector does not depend on the order of its input.
/// Keeps its memory between calls.
class Ordering {
 public:
  /// Writes all rows in random order: sorts them by their coordinates, an order that neither a shift nor
  /// another unit alters, and shuffles them with the seed. Any run of consecutive rows is then a fair sample.
  /// O(N), or O(N log N) if most matches share their left x.
  void shuffle(const Correspondences& matches, std::uint64_t seed, std::vector<std::uint32_t>& rows);

  /// Writes the positions in `rows`, best first. The key is the distance divided by the second-nearest
  /// distance, or the distance alone if there is no second one, or 1 - probability if there are no distances
  /// (match_costs.h). Matches without a key come last. Ties keep the order of `rows`. O(N).
  /// @return false, with nothing written, if no match has a key
  bool byQuality(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                 std::vector<std::uint32_t>& positions);

 private:
  std::vector<float> costs_;  // of each row
  std::vector<KeyedRow> items_, scratch_;
};

}  // namespace corrsel::core
