#include "selectors/parts/trusted_set.h"

#include <algorithm>
#include <cmath>

#include "base/coordinate_order.h"
#include "base/saturated.h"

namespace corrsel::core {

std::string TrustedSet::missingInput(const Correspondences& matches, const char* who) {
  if (matches.empty() || (!matches.distance.empty() && !matches.second_distance.empty())) return "";
  return std::string(who) + " needs the column " +
         (matches.distance.empty() ? "distance" : "second_distance");
}

void TrustedSet::find(const Correspondences& matches, double max_ratio) {
  items_.clear();
  mask_.assign(matches.size(), 0);
  size_ = 0;
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    const double first = matches.distance[i], second = matches.second_distance[i];
    // Comparisons with NaN are false.
    if (!(first >= 0 && second > 0 && std::isfinite(second) && first < max_ratio * second)) continue;
    const auto column = static_cast<std::uint32_t>(saturated(std::round(matches.right_x[i])));
    const auto row = static_cast<std::uint32_t>(saturated(std::round(matches.right_y[i])));
    items_.push_back({std::uint64_t{column} << 32 | row, sortKey(static_cast<float>(first / second)), i});
  }
  std::sort(items_.begin(), items_.end(), [&matches](const Item& a, const Item& b) {
    if (a.place != b.place) return a.place < b.place;
    if (a.ratio != b.ratio) return a.ratio < b.ratio;
    const int order = compareCoordinates(matches, a.row, b.row);
    return order != 0 ? order < 0 : a.row < b.row;
  });
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (i > 0 && items_[i].place == items_[i - 1].place) continue;
    mask_[items_[i].row] = 1;
    ++size_;
  }
}

}  // namespace corrsel::core
