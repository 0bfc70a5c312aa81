#include "search/frame_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/gather.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMostScored = 3000;  // matches
constexpr std::size_t kJudges = 500;       // matches that each map is judged by
constexpr double kTolerance = 0.02;        // of the diagonal of the right image
constexpr double kLeastDiagonal = 1;       // px

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
  maps_.clear();
  seeds_.clear();
  for (std::size_t k = 0; k < n && seeds_.size() < kMostScored; ++k) {
    const std::uint32_t i = best_first != nullptr ? (*best_first)[k] : static_cast<std::uint32_t>(k);
    const auto map = frameMap(matches.left_frame[rows[i]], matches.right_frame[rows[i]]);
    if (!map) continue;
    maps_.push_back(*map);
    seeds_.push_back(i);
  }
  next_ = 0;
  taken_.assign(n, 0);
  order_.clear();
  if (seeds_.empty()) return;
  const bool sized = matches.right_size.width > 0 && matches.right_size.height > 0;
  diagonal_ = std::max(kLeastDiagonal,
                       sized ? std::hypot(matches.right_size.width, matches.right_size.height)
                             : std::hypot(extent(taking_part_.right_x), extent(taking_part_.right_y)));
  score(best_first);
  weights_.assign(n, 1);
  growing_.assign(taking_part_, weights_, diagonal_);
}

/// Sorts the maps by their scores.
void FrameHypotheses::score(const std::vector<std::uint32_t>* best_first) {
  const Correspondences& m = taking_part_;
  const double tolerance = kTolerance * diagonal_;
  const std::size_t judges = std::min(kJudges, m.size());
  const auto gather = [&](const std::vector<float>& from, std::vector<float>& to) {
    to.resize(judges);
    for (std::size_t k = 0; k < judges; ++k) to[k] = from[best_first != nullptr ? (*best_first)[k] : k];
  };
  gather(m.left_x, judges_.left_x);
  gather(m.left_y, judges_.left_y);
  gather(m.right_x, judges_.right_x);
  gather(m.right_y, judges_.right_y);
  const MatchColumns columns = {judges_.left_x.data(), judges_.left_y.data(), judges_.right_x.data(),
                                judges_.right_y.data(), judges};
  order_.resize(maps_.size());
  for (std::size_t begin = 0; begin < maps_.size(); begin += AffineMaps::kMaps) {
    const std::size_t count = std::min(AffineMaps::kMaps, maps_.size() - begin);
    AffineMaps side_by_side{};
    float gains[AffineMaps::kMaps];
    for (std::size_t k = 0; k < count; ++k) {
      const LinearMap& a = maps_[begin + k];
      const std::uint32_t seed = seeds_[begin + k];
      const float map[6] = {a[0], a[1], m.right_x[seed] - a[0] * m.left_x[seed] - a[1] * m.left_y[seed],
                            a[2], a[3], m.right_y[seed] - a[2] * m.left_x[seed] - a[3] * m.left_y[seed]};
      for (std::size_t i = 0; i < std::size(map); ++i) side_by_side.m[i][k] = map[i];
    }
    kernels().support.affine_gains(side_by_side, columns, static_cast<float>(1 / (tolerance * tolerance)),
                                   gains);
    for (std::size_t k = 0; k < count; ++k)
      order_[begin + k] = {~sortKey(gains[k]), static_cast<std::uint32_t>(begin + k)};
  }
  radixSort(order_, scratch_);
}

bool FrameHypotheses::next() {
  while (next_ < order_.size() && taken_[seeds_[order_[next_].row]] != 0) ++next_;
  grown_ = false;
  if (next_ == order_.size()) return false;
  const std::uint32_t best = order_[next_++].row;
  grown_ = growing_.grow(seeds_[best], maps_[best]);
  for (const std::uint32_t i : growing_.supporters()) taken_[i] = 1;
  return true;
}

}  // namespace corrsel::core
