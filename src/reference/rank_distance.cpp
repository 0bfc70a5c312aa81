#include "reference/rank_distance.h"

#include <algorithm>
#include <cstdlib>

namespace corrsel::core {
namespace {

/// Differences of two ranks over the smaller one, because divisions take long.
struct Quotients {
  double of[RankDistance::kMax][RankDistance::kMax + 1];

  Quotients() : of{} {
    for (int difference = 0; difference < RankDistance::kMax; ++difference) {
      for (int smaller = 1; smaller <= RankDistance::kMax; ++smaller)
        of[difference][smaller] = static_cast<double>(difference) / smaller;
    }
  }
};

const Quotients& allQuotients() {
  static const Quotients kTable;
  return kTable;
}

}  // namespace

RankDistance::RankDistance(int k) : k_(k) {
  double sum = 0;
  for (int t = 1; t <= k / 2; ++t) sum += 1.0 / t;
  const double z = k - 4.0 * (k / 2) + 2.0 * (k + 1) * sum;
  largest_ = 2 * z - 2 * k;
}

double RankDistance::operator()(const std::uint8_t* places) const {
  const Quotients& quotients = allQuotients();
  std::uint8_t common_places[kMax], rank[kMax + 1];  // the last rank is for members without a partner
  std::fill(rank, rank + k_ + 1, std::uint8_t{0});
  int common = 0;
  for (int b = 0; b < k_; ++b) {
    const bool both = places[b] < k_;
    common_places[common] = places[b];
    common += both ? 1 : 0;
    rank[both ? places[b] : k_] = 1;
  }
  for (int a = 1; a < k_; ++a) rank[a] = static_cast<std::uint8_t>(rank[a] + rank[a - 1]);
  double sum = 0;
  for (int q = 1; q <= common; ++q) {
    const int p = rank[common_places[q - 1]];
    sum += quotients.of[std::abs(p - q)][std::min(p, q)];
  }
  return (sum + 2 * (k_ - common) * perStranger()) / largest_;
}

}  // namespace corrsel::core
