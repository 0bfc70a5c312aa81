#pragma once

#include <limits>

#include "search/frame_hypotheses.h"
#include "search/proposal.h"

namespace corrsel::core {

/// Proposes homographies from the local affine frames of single matches, at most 60. They are rough.
/// read() must be given matches with frames; the model must be a homography. The proposals end when four
/// in a row have brought nothing better than a model with at least 40 inliers.
class FrameProposal final : public Proposal {
 public:
  FrameProposal();

  void read(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
            const std::vector<std::uint32_t>* best_first) override;
  void start(const ProposalInput& input) override;
  bool isFinished(const Candidate& best) override;
  Proposed propose(Hypotheses& hypotheses) override;

 private:
  FrameHypotheses frames_;
  const NormalizedMatches* matches_ = nullptr;
  std::int64_t cost_ = 0;  // of the best model
  int fruitless_ = 0;      // proposals since it was found
};

}  // namespace corrsel::core
