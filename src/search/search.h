#pragma once

#include <cstdint>
#include <vector>

#include "base/deadline.h"
#include "corrsel/workspace.h"
#include "geometry/normalization.h"
#include "search/model.h"
#include "search/parameters.h"
#include "search/proposal.h"
#include "search/second_score.h"
#include "search/verifier.h"

namespace corrsel::core {

/// The exchangeable parts of a search.
struct SearchParts {
  const Model& model;
  Proposal& proposal;
  SecondScore* second_score = nullptr;  ///< nullptr: MSAC or the number of inliers alone decides
  /// A hypothesis from elsewhere, refined before the first sample is drawn. The floor of the model
  /// (ModelTraits::floor) does not apply then. nullptr: none. Only of models that refine fully.
  const cv::Matx33d* first = nullptr;
};

/// What search() found.
struct SearchOutcome {
  Candidate best;                ///< normalised, with cost and inliers among the matches that took part
  int iterations = 0;            ///< hypotheses
  bool timed_out = false;        ///< whether the deadline ended the search
  bool no_valid_sample = false;  ///< whether it ended because no sample passed the check
};

/// Searches for the model that most matches agree with: random sample consensus.
///
/// Algorithm: until the stopping rule (search/stopping.h), the number of iterations or the deadline ends it,
/// the proposal gives hypotheses. Each is scored until it cannot be the best one (bail-out, SPRT;
/// search/verifier.h, search/sprt.h). A new best one is taken off a degenerate configuration by its model,
/// and refined (search/local_optimization.h). A search that has not ended after 2000 hypotheses also draws
/// samples from the matches that agree with the best of the later ones (search/inner_sampling.h). Models
/// that are refined to convergence (ModelTraits::refines_fully) have no inner samples: hypotheses are then
/// compared before their refinement, and a number of samples that depends on the inliers is drawn at least.
/// The clock is read every 100 samples and after each new best model; slow proposals read it each time.
/// @param matches     in random order (Ordering::shuffle())
/// @param best_first  positions in `matches` without repetition, best first, which is of use to proposals
///                    with uses_quality. Only these matches take part. nullptr: all take part, all alike
/// @pre at least as many matches take part as a sample has
SearchOutcome search(const NormalizedMatches& matches, const SearchParts& parts,
                     const SearchParameters& parameters, const std::vector<std::uint32_t>* best_first,
                     const Deadline& deadline, Workspace& workspace);

}  // namespace corrsel::core
