#include "search/frame_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/gather.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMaxScored = 3000;  // matches
constexpr std::size_t kSample = 500;      // matches that each map is scored by
constexpr double kTolerance = 0.02;       // of the diagonal of the right image
constexpr double kMinDiagonal = 1;        // px

double extent(const std::vector<float>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return static_cast<double>(*high) - *low;
}

}  // namespace

void FrameHypotheses::assign(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                             const std::vector<std::uint32_t>* best_first) {
  const std::size_t n = rows.size();
  gather(matches.left_x, rows, taking_part_.left_x);
  gather(matches.left_y, rows, taking_part_.left_y);
  gather(matches.right_x, rows, taking_part_.right_x);
  gather(matches.right_y, rows, taking_part_.right_y);
  maps_.resize(n);
  weights_.assign(n, 1);
  seeds_.clear();
  for (std::size_t k = 0; k < n && seeds_.size() < kMaxScored; ++k) {
    const std::uint32_t i = best_first != nullptr ? (*best_first)[k] : static_cast<std::uint32_t>(k);
    const auto map = frameMap(matches.left_frame[rows[i]], matches.right_frame[rows[i]]);
    if (!map) continue;
    maps_[i] = *map;
    seeds_.push_back(i);
  }
  if (seeds_.empty()) return growing_.start(taking_part_, weights_, 0, seeds_, maps_);
  const bool sized = matches.right_size.width > 0 && matches.right_size.height > 0;
  diagonal_ =
      std::max(kMinDiagonal, sized ? std::hypot(matches.right_size.width, matches.right_size.height)
                                   : std::hypot(extent(taking_part_.right_x), extent(taking_part_.right_y)));
  sortSeeds(best_first);
  growing_.start(taking_part_, weights_, diagonal_, seeds_, maps_);
}

/// Sorts the seeds by the scores of their maps.
void FrameHypotheses::sortSeeds(const std::vector<std::uint32_t>* best_first) {
  const Correspondences& m = taking_part_;
  const double tolerance = kTolerance * diagonal_;
  const std::size_t sample = std::min(kSample, m.size());
  const auto gather = [&](const std::vector<float>& from, std::vector<float>& to) {
    to.resize(sample);
    for (std::size_t k = 0; k < sample; ++k) to[k] = from[best_first != nullptr ? (*best_first)[k] : k];
  };
  gather(m.left_x, sample_.left_x);
  gather(m.left_y, sample_.left_y);
  gather(m.right_x, sample_.right_x);
  gather(m.right_y, sample_.right_y);
  const MatchColumns columns = {sample_.left_x.data(), sample_.left_y.data(), sample_.right_x.data(),
                                sample_.right_y.data(), sample};
  order_.resize(seeds_.size());
  for (std::size_t begin = 0; begin < seeds_.size(); begin += AffineMaps::kMaps) {
    const std::size_t count = std::min(AffineMaps::kMaps, seeds_.size() - begin);
    AffineMaps side_by_side{};
    float gains[AffineMaps::kMaps];
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t seed = seeds_[begin + k];
      const LinearMap& a = maps_[seed];
      const float map[6] = {a[0], a[1], m.right_x[seed] - a[0] * m.left_x[seed] - a[1] * m.left_y[seed],
                            a[2], a[3], m.right_y[seed] - a[2] * m.left_x[seed] - a[3] * m.left_y[seed]};
      for (std::size_t i = 0; i < std::size(map); ++i) side_by_side.m[i][k] = map[i];
    }
    kernels().support.affine_gains(side_by_side, columns, static_cast<float>(1 / (tolerance * tolerance)),
                                   gains);
    for (std::size_t k = 0; k < count; ++k) order_[begin + k] = {~sortKey(gains[k]), seeds_[begin + k]};
  }
  radixSort(order_, scratch_);
  for (std::size_t k = 0; k < order_.size(); ++k) seeds_[k] = order_[k].row;
}

}  // namespace corrsel::core
