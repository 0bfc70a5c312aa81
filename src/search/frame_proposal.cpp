#include "search/frame_proposal.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kManyInliers = 40;  // with which the search ends after
constexpr int kMaxFruitless = 3;          // maps that bring nothing better

ProposalTraits frameTraits() {
  ProposalTraits traits{"local affine frames"};
  traits.uses_quality = true;
  traits.rough = traits.crowded = traits.slow = true;
  traits.max_iterations = 60;
  return traits;
}

}  // namespace

FrameProposal::FrameProposal() : Proposal(frameTraits()) {}

void FrameProposal::read(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                         const std::vector<std::uint32_t>* best_first) {
  frames_.assign(matches, rows, best_first);
}

void FrameProposal::start(const ProposalInput& input) {
  matches_ = &input.matches;
  drawn_ = 0;
  fruitless_ = 0;
  cost_ = std::numeric_limits<std::int64_t>::max();
}

bool FrameProposal::isFinished(const Candidate& best) {
  if (best.cost < cost_) {
    cost_ = best.cost;
    fruitless_ = 0;
  }
  return best.distinct >= kManyInliers && fruitless_ > kMaxFruitless;
}

Proposed FrameProposal::propose(Hypotheses& hypotheses) {
  ++drawn_;
  if (!frames_.next()) return Proposed::kNothingLeft;
  ++fruitless_;
  hypotheses.count = frames_.map() != nullptr ? 1 : 0;
  if (hypotheses.count > 0) hypotheses.models[0] = matches_->homographyFromPixels(*frames_.map());
  return Proposed::kHypotheses;
}

}  // namespace corrsel::core
