#include "search/local_proposal.h"

#include <algorithm>
#include <iterator>

#include "search/prosac_proposal.h"

namespace corrsel::core {
namespace {

ProposalTraits localTraits() {
  ProposalTraits traits{"samples of neighbours"};
  traits.uses_quality = true;
  traits.crowded = true;
  traits.iterations = 30000;  // samples, which take longer than others
  return traits;
}

}  // namespace

void MatchNeighbourhood::build(const NormalizedMatches& matches) {
  matches_ = &matches;
  neighbours_.build(matches.left_x.data(), matches.left_y.data(), matches.size(), 2 * kMaxSize);
}

int MatchNeighbourhood::find(std::uint32_t match, int k, std::uint32_t* out) const {
  struct Near {
    float distance;
    std::uint32_t match;
  };
  std::uint32_t candidates[2 * kMaxSize];
  Near near[2 * kMaxSize];
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

LocalProposal::LocalProposal() : SampleProposal(localTraits()) {}

void LocalProposal::drawSample(std::uint32_t* sample) {
  constexpr int kSizes[] = {8, 16, MatchNeighbourhood::kMaxSize};
  const std::size_t turn = drawn_ % (std::size(kSizes) + 1);
  const std::uint64_t round = drawn_ / (std::size(kSizes) + 1);
  if (turn < std::size(kSizes)) {
    std::uint32_t near[MatchNeighbourhood::kMaxSize];
    sample[0] = order_ != nullptr && round % 2 == 0 ? (*order_)[round / 2 % count_] : random_.index(count_);
    const auto found = static_cast<std::uint32_t>(near_.find(sample[0], kSizes[turn], near));
    if (found + 1 >= sample_size_) {
      random_.sample(found, sample_size_ - 1, sample + 1);
      for (std::size_t k = 1; k < sample_size_; ++k) sample[k] = near[sample[k]];
      return;
    }
  }
  if (order_ == nullptr) {
    random_.sample(count_, sample_size_, sample);
    return;
  }
  random_.sample(prefixInTurn(count_, round, model_->traits.prosac), sample_size_, sample);
  for (std::size_t k = 0; k < sample_size_; ++k) sample[k] = (*order_)[sample[k]];
}

}  // namespace corrsel::core
