#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "base/deadline.h"
#include "corrsel/correspondences.h"
#include "corrsel/random.h"
#include "geometry/normalization.h"
#include "search/model.h"

namespace corrsel::core {

/// What a proposal draws from, and for how long.
struct ProposalInput {
  const NormalizedMatches& matches;              ///< that take part, in random order
  const std::vector<std::uint32_t>* best_first;  ///< all of them by quality; nullptr = all alike
  const Model& model;
  int max_iterations;
  std::uint64_t seed;
  const Deadline& deadline;
};

enum class Proposed : std::uint8_t { kHypotheses, kNothingLeft, kNoValidSample, kTimeLimit };

/// What the search must know of a way to propose hypotheses.
struct ProposalTraits {
  const char* name;  ///< in messages
  /// Whether the order of the matches by quality is of use, and whether the user is told where it is unknown.
  bool uses_quality = false, reports_missing_quality = false;
  bool rough = false;    ///< hypotheses must be refined before they are compared
  bool crowded = false;  ///< most samples among outliers are refused, so that they count as hypotheses
  bool slow = false;     ///< a proposal takes O(N) or more, so that the clock is read for each
  int iterations = 0;    ///< hypotheses where the user gives no number; 0 = those of the model
  int max_iterations = 10000000;  ///< even where the user allows more
};

/// Proposes the hypotheses of a search. Keeps its memory between searches.
class Proposal {
 public:
  explicit Proposal(const ProposalTraits& values) : traits(values) {}
  virtual ~Proposal() = default;

  /// Takes what NormalizedMatches do not hold, before start().
  /// @param rows        those that take part, in random order
  /// @param best_first  positions in `rows`; nullptr = unknown
  virtual void read(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                    const std::vector<std::uint32_t>* best_first);

  /// Begins a search. What the input refers to must outlive the search.
  virtual void start(const ProposalInput& input) = 0;

  /// Whether it is not worth going on after this best model.
  virtual bool isFinished(const Candidate& best);

  virtual Proposed propose(Hypotheses& hypotheses) = 0;

  /// Is told every hypothesis that the search has scored.
  virtual void learn(const cv::Matx33d& hypothesis);

  /// Samples drawn since start(), among them up to a batch that have not been proposed yet.
  std::uint64_t drawn() const { return drawn_; }

  /// The order whose prefixes may end the search, and the size of the prefix from which all samples so far
  /// were drawn. nullptr: samples are not drawn from prefixes.
  virtual const std::vector<std::uint32_t>* prefixes() const { return nullptr; }
  virtual std::uint32_t pool() const { return 0; }

  const ProposalTraits traits;

 protected:
  std::uint64_t drawn_ = 0;
};

/// Proposes what the minimal solver makes of samples that pass the check. Samples are drawn and solved in
/// batches where the model solves several together.
class SampleProposal : public Proposal {
 public:
  using Proposal::Proposal;
  void start(const ProposalInput& input) override;
  Proposed propose(Hypotheses& hypotheses) override;

  /// Writes one sample of distinct matches. O(m^2) unless the proposal is slow.
  void draw(std::uint32_t* sample);

 protected:
  virtual void prepare() {}
  /// Writes sample number `drawn_`, counted from 1.
  virtual void drawSample(std::uint32_t* sample) = 0;

  const NormalizedMatches* matches_ = nullptr;
  const Model* model_ = nullptr;
  const std::vector<std::uint32_t>* order_ = nullptr;
  std::uint32_t count_ = 0;  // matches
  std::size_t sample_size_ = 0;
  Random random_;

 private:
  Proposed drawValid(Hypotheses& hypotheses);

  const Deadline* deadline_ = nullptr;
  std::uint64_t max_samples_ = 0;
  Hypotheses batch_[kMaxBatch];  // solved and not yet proposed: [next_, solved_)
  int next_ = 0, solved_ = 0;
};

}  // namespace corrsel::core
