#include "base/spread_selection.h"

#include <limits>

namespace corrsel::core {

Selection spreadSelection(Selection some, const std::vector<std::uint32_t>& rows, std::size_t n) {
  constexpr float kNoScore = std::numeric_limits<float>::quiet_NaN();
  some.mask = spread(some.mask, rows, n, std::uint8_t{0});
  if (!some.score.empty()) some.score = spread(some.score, rows, n, kNoScore);
  if (!some.group.empty()) some.group = spread(some.group, rows, n, -1);
  if (!some.probability.empty()) some.probability = spread(some.probability, rows, n, 0.0F);
  some.n_input = n;
  return some;
}

}  // namespace corrsel::core
