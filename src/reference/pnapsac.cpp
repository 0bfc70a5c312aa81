#include "corrsel/reference/pnapsac.h"

#include "reference/growing_neighbourhoods.h"
#include "reference/search_options.h"
#include "search/prosac_proposal.h"

namespace corrsel::core {
namespace {

/// Local samples first, and then those of PROSAC.
class PnapsacProposal final : public ProsacProposal {
 public:
  PnapsacProposal() : ProsacProposal({"Progressive NAPSAC", true, true}) {}

  std::uint32_t pool() const override { return drawn_ <= local_samples_ ? count_ : ProsacProposal::pool(); }

 private:
  void prepare() override {
    ProsacProposal::prepare();
    local_samples_ = 0;
    if (order_ == nullptr) return;
    near_.build(*matches_, *order_, static_cast<int>(sample_size_));
    local_samples_ = near_.samples();
    delay(local_samples_);
  }

  void drawSample(std::uint32_t* sample) override {
    const bool local = drawn_ <= local_samples_;
    if (!local || !near_.draw(random_, static_cast<std::uint32_t>(drawn_ - 1), sample))
      ProsacProposal::drawSample(sample);
  }

  GrowingNeighbourhoods near_;
  std::uint64_t local_samples_ = 0;
};

}  // namespace

void PnapsacSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  selectByUsac(matches, options_, workspace.part<PnapsacProposal>(), workspace, result);
}

}  // namespace corrsel::core
