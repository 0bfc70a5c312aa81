#include "selectors/parts/rank_distance.h"

#include <algorithm>
#include <cstdlib>

namespace corrsel::core {

RankDistance::RankDistance(int k) : k_(k) {
  double sum = 0;
  for (int t = 1; t <= k / 2; ++t) sum += 1.0 / t;
  const double z = k - 4.0 * (k / 2) + 2.0 * (k + 1) * sum;
  largest_ = 2 * z - 2 * k;
}

double RankDistance::operator()(const std::uint32_t* left, const std::uint32_t* right) const {
  int place[kMost];  // in the left list, of each common member in the order of the right list
  int common = 0;
  for (int b = 0; b < k_; ++b) {
    const auto a = static_cast<int>(std::find(left, left + k_, right[b]) - left);
    if (a < k_) place[common++] = a;
  }
  double sum = 0;
  for (int q = 1; q <= common; ++q) {
    const int own = place[q - 1];
    const auto p = static_cast<int>(std::count_if(place, place + common, [own](int a) { return a <= own; }));
    sum += static_cast<double>(std::abs(p - q)) / std::min(p, q);
  }
  return (sum + 2 * (k_ - common) * perStranger()) / largest_;
}

}  // namespace corrsel::core
