#include "corrsel/reference/multigs.h"

#include "geometry/residual.h"
#include "reference/hypothesis_affinity.h"
#include "reference/search_options.h"

namespace corrsel::core {
namespace {

ProposalTraits multigsTraits() {
  ProposalTraits traits{"Multi-GS"};
  traits.crowded = traits.slow = true;
  // Each of them takes O(N).
  traits.iterations = 5000;
  return traits;
}

class MultigsProposal final : public SampleProposal {
 public:
  MultigsProposal() : SampleProposal(multigsTraits()) {}

  void learn(const cv::Matx33d& hypothesis) override {
    modelErrors(model_->traits.residual, hypothesis, *matches_, 0, matches_->size(), affinity_.next());
    affinity_.add();
  }

 private:
  void prepare() override { affinity_.start(matches_->size()); }
  void drawSample(std::uint32_t* sample) override { affinity_.draw(random_, sample_size_, sample); }

  HypothesisAffinity affinity_;
};

}  // namespace

void MultigsSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  selectByUsac(matches, options_, workspace.part<MultigsProposal>(), workspace, result);
}

}  // namespace corrsel::core
