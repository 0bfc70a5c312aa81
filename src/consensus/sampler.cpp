#include "consensus/sampler.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {

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

void Sampler::growPool() {
  const double next = expected_ * (pool_ + 1.0) / (pool_ + 1.0 - sample_size_);
  pool_end_ += static_cast<std::uint64_t>(std::ceil(next - expected_));
  expected_ = next;
  ++pool_;
}

void Sampler::draw(std::uint32_t* sample) {
  ++drawn_;
  const auto m = static_cast<std::size_t>(sample_size_);
  if (order_ == nullptr) {
    random_.sample(count_, m, sample);
    return;
  }
  while (drawn_ > pool_end_ && pool_ < count_) growPool();
  if (drawn_ > pool_end_) {
    constexpr std::uint32_t kLeastPrefix = 20;
    const auto halvings = static_cast<unsigned>(drawn_ % static_cast<std::uint64_t>(schedule_.prefixes));
    random_.sample(std::max(count_ >> halvings, std::min(count_, kLeastPrefix)), m, sample);
  } else {
    random_.sample(pool_ - 1, m - 1, sample);
    sample[m - 1] = pool_ - 1;
  }
  for (std::size_t k = 0; k < m; ++k) sample[k] = (*order_)[sample[k]];
}

}  // namespace corrsel::core
