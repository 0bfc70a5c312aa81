#include "search/proposal.h"

#include <algorithm>

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
  next_ = solved_ = 0;
  prepare();
}

void SampleProposal::draw(std::uint32_t* sample) {
  ++drawn_;
  drawSample(sample);
}

Proposed SampleProposal::propose(Hypotheses& hypotheses) {
  if (next_ == solved_) {
    next_ = solved_ = 0;
    Proposed drawn = Proposed::kHypotheses;
    while (solved_ < model_->traits.batch && drawn == Proposed::kHypotheses) {
      drawn = drawValid(batch_[solved_]);
      if (drawn == Proposed::kHypotheses) ++solved_;
    }
    if (solved_ == 0) return drawn;
    model_->solveBatch(*matches_, batch_, solved_);
  }
  const Hypotheses& next = batch_[next_++];
  std::copy(next.models, next.models + next.count, hypotheses.models);
  std::copy(next.sample, next.sample + sample_size_, hypotheses.sample);
  hypotheses.count = next.count;
  return Proposed::kHypotheses;
}

/// Draws a sample that passes the check.
Proposed SampleProposal::drawValid(Hypotheses& hypotheses) {
  for (int refused = 0; refused < kMaxRefusals && drawn_ < max_samples_; ++refused) {
    if (traits.slow && refused > 0 && deadline_->passed()) return Proposed::kTimeLimit;
    draw(hypotheses.sample);
    if (!model_->isValidSample(*matches_, hypotheses.sample)) continue;
    return Proposed::kHypotheses;
  }
  return Proposed::kNoValidSample;
}

}  // namespace corrsel::core
