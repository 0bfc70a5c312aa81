#pragma once

#include "search/proposal.h"

namespace corrsel::core {

/// Samples of matches that are all alike.
class UniformProposal final : public SampleProposal {
 public:
  UniformProposal() : SampleProposal({"uniform samples"}) {}

 private:
  void drawSample(std::uint32_t* sample) override { random_.sample(count_, sample_size_, sample); }
};

}  // namespace corrsel::core
