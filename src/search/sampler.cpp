#include "search/sampler.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace corrsel::core {

void MatchNeighbourhood::build(const NormalizedMatches& matches) {
  matches_ = &matches;
  neighbours_.build(matches.left_x.data(), matches.left_y.data(), matches.size(), 2 * kLargest);
}

int MatchNeighbourhood::find(std::uint32_t match, int k, std::uint32_t* out) const {
  struct Near {
    float distance;
    std::uint32_t match;
  };
  std::uint32_t candidates[2 * kLargest];
  Near near[2 * kLargest];
  const NormalizedMatches& m = *matches_;
  const int found = neighbours_.nearest(m.left_x[match], m.left_y[match], 2 * k, candidates);
  int count = 0;
  for (int i = 0; i < found; ++i) {
    const std::uint32_t j = candidates[i];
    if (j == match) continue;
    const float dx = m.left_x[j] - m.left_x[match], dy = m.left_y[j] - m.left_y[match];
    const float du = m.right_x[j] - m.right_x[match], dv = m.right_y[j] - m.right_y[match];
    near[count++] = {dx * dx + dy * dy + du * du + dv * dv, j};
  }
  const int kept = std::min(count, k);
  std::nth_element(near, near + kept, near + count, [](const Near& a, const Near& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.match < b.match;
  });
  // The order that nth_element leaves depends on the library.
  std::sort(near, near + kept, [](const Near& a, const Near& b) { return a.match < b.match; });
  for (int i = 0; i < kept; ++i) out[i] = near[i].match;
  return kept;
}

Sampler::Sampler(std::size_t count, int sample_size, std::uint64_t seed)
    : count_(static_cast<std::uint32_t>(count)), sample_size_(sample_size), random_(seed), pool_(count_) {}

Sampler::Sampler(const std::vector<std::uint32_t>& order, int sample_size, std::uint64_t seed,
                 const ProsacSchedule& schedule)
    : Sampler(order.size(), sample_size, seed) {
  order_ = &order;
  schedule_ = schedule;
  pool_ = static_cast<std::uint32_t>(sample_size);
  expected_ = schedule.samples;
  for (int i = 0; i < sample_size; ++i)
    expected_ *= static_cast<double>(sample_size - i) / (count_ - static_cast<std::uint32_t>(i));
}

Sampler::Sampler(const MatchNeighbourhood& near, std::size_t count,
                 const std::vector<std::uint32_t>* best_first, int sample_size, std::uint64_t seed,
                 const ProsacSchedule& schedule)
    : Sampler(count, sample_size, seed) {
  near_ = &near;
  order_ = best_first;
  schedule_ = schedule;
}

Sampler::Sampler(GrowingNeighbourhoods& near, const std::vector<std::uint32_t>& order, int sample_size,
                 std::uint64_t seed, const ProsacSchedule& schedule)
    : Sampler(order, sample_size, seed, schedule) {
  growing_ = &near;
  growing_samples_ = near.samples();
  pool_end_ += growing_samples_;  // PROSAC begins after them
}

Sampler::Sampler(HypothesisAffinity& affinity, std::size_t count, int sample_size, std::uint64_t seed)
    : Sampler(count, sample_size, seed) {
  affinity_ = &affinity;
}

void Sampler::drawNear(std::uint32_t* sample) {
  constexpr int kSizes[] = {8, 16, MatchNeighbourhood::kLargest};
  const auto m = static_cast<std::size_t>(sample_size_);
  const std::size_t turn = drawn_ % (std::size(kSizes) + 1);
  if (turn < std::size(kSizes)) {
    std::uint32_t near[MatchNeighbourhood::kLargest];
    const std::uint64_t round = drawn_ / (std::size(kSizes) + 1);
    sample[0] = order_ != nullptr && round % 2 == 0 ? (*order_)[round / 2 % count_] : random_.index(count_);
    const int found = near_->find(sample[0], kSizes[turn], near);
    if (found >= sample_size_ - 1) {
      random_.sample(static_cast<std::uint32_t>(found), m - 1, sample + 1);
      for (std::size_t k = 1; k < m; ++k) sample[k] = near[sample[k]];
      return;
    }
  }
  random_.sample(order_ != nullptr ? prefix(drawn_ / (std::size(kSizes) + 1)) : count_, m, sample);
  for (std::size_t k = 0; k < m && order_ != nullptr; ++k) sample[k] = (*order_)[sample[k]];
}

std::uint32_t Sampler::prefix(std::uint64_t turn) const {
  constexpr std::uint32_t kLeastPrefix = 20;
  const auto halvings = static_cast<unsigned>(turn % static_cast<std::uint64_t>(schedule_.prefixes));
  return std::max(count_ >> halvings, std::min(count_, kLeastPrefix));
}

void Sampler::growPool() {
  const double next = expected_ * (pool_ + 1.0) / (pool_ + 1.0 - sample_size_);
  pool_end_ += static_cast<std::uint64_t>(std::ceil(next - expected_));
  expected_ = next;
  ++pool_;
}

void Sampler::draw(std::uint32_t* sample) {
  ++drawn_;
  const auto m = static_cast<std::size_t>(sample_size_);
  if (near_ != nullptr) {
    drawNear(sample);
    return;
  }
  if (affinity_ != nullptr) {
    affinity_->draw(random_, m, sample);
    return;
  }
  if (drawn_ <= growing_samples_ && growing_->draw(random_, static_cast<std::uint32_t>(drawn_ - 1), sample))
    return;
  if (order_ == nullptr) {
    random_.sample(count_, m, sample);
    return;
  }
  while (drawn_ > pool_end_ && pool_ < count_) growPool();
  if (drawn_ > pool_end_) {
    random_.sample(prefix(drawn_), m, sample);
  } else {
    random_.sample(pool_ - 1, m - 1, sample);
    sample[m - 1] = pool_ - 1;
  }
  for (std::size_t k = 0; k < m; ++k) sample[k] = (*order_)[sample[k]];
}

}  // namespace corrsel::core
