#include "search/prosac_proposal.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {

std::uint32_t prefixInTurn(std::uint32_t count, std::uint64_t turn, const ProsacSchedule& schedule) {
  const auto halvings = static_cast<unsigned>(turn % static_cast<std::uint64_t>(schedule.prefixes));
  return std::max(count >> halvings, std::min(count, kMinPrefix));
}

void ProsacProposal::prepare() {
  schedule_ = model_->traits.prosac;
  pool_ = order_ != nullptr ? static_cast<std::uint32_t>(sample_size_) : count_;
  pool_end_ = 1;
  expected_ = schedule_.samples;
  for (std::uint32_t i = 0; i < sample_size_; ++i)
    expected_ *= static_cast<double>(sample_size_ - i) / (count_ - i);
}

void ProsacProposal::growPool() {
  const double next = expected_ * (pool_ + 1.0) / (pool_ + 1.0 - static_cast<double>(sample_size_));
  pool_end_ += static_cast<std::uint64_t>(std::ceil(next - expected_));
  expected_ = next;
  ++pool_;
}

void ProsacProposal::drawSample(std::uint32_t* sample) {
  if (order_ == nullptr) {
    random_.sample(count_, sample_size_, sample);
    return;
  }
  while (drawn_ > pool_end_ && pool_ < count_) growPool();
  if (drawn_ > pool_end_) {
    random_.sample(prefixInTurn(count_, drawn_, schedule_), sample_size_, sample);
  } else {
    random_.sample(pool_ - 1, sample_size_ - 1, sample);
    sample[sample_size_ - 1] = pool_ - 1;
  }
  for (std::size_t k = 0; k < sample_size_; ++k) sample[k] = (*order_)[sample[k]];
}

}  // namespace corrsel::core
