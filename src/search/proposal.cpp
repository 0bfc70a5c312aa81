#include "search/proposal.h"

namespace corrsel::core {
namespace {

// As in OpenCV, so many refusals mean that there is no valid sample.
constexpr int kMaxRefusals = 10000;
// Limits the average number of samples per hypothesis, for data with hardly any valid sample.
constexpr std::uint64_t kSamplesPerHypothesis = 50;

}  // namespace

void Proposal::read(const Correspondences&, const std::vector<std::uint32_t>&,
                    const std::vector<std::uint32_t>*) {}

bool Proposal::isFinished(const Candidate&) { return false; }

void Proposal::learn(const cv::Matx33d&) {}

void SampleProposal::start(const ProposalInput& input) {
  matches_ = &input.matches;
  model_ = &input.model;
  order_ = input.best_first;
  count_ = static_cast<std::uint32_t>(input.matches.size());
  sample_size_ = static_cast<std::size_t>(input.model.traits.sample_size);
  random_ = Random(input.seed);
  deadline_ = &input.deadline;
  max_samples_ = kMaxRefusals + kSamplesPerHypothesis * static_cast<std::uint64_t>(input.max_iterations);
  drawn_ = 0;
  prepare();
}

void SampleProposal::draw(std::uint32_t* sample) {
  ++drawn_;
  drawSample(sample);
}

Proposed SampleProposal::propose(Hypotheses& hypotheses) {
  for (int refused = 0; refused < kMaxRefusals && drawn_ < max_samples_; ++refused) {
    if (traits.slow && refused > 0 && deadline_->passed()) return Proposed::kTimeLimit;
    draw(hypotheses.sample);
    if (!model_->isValidSample(*matches_, hypotheses.sample)) continue;
    hypotheses.count = model_->solve(*matches_, hypotheses.sample, hypotheses.models);
    return Proposed::kHypotheses;
  }
  return Proposed::kNoValidSample;
}

}  // namespace corrsel::core
