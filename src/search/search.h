#pragma once

#include <cstdint>
#include <vector>

#include "base/deadline.h"
#include "corrsel/correspondences.h"
#include "corrsel/search/options.h"
#include "corrsel/selection.h"
#include "geometry/normalization.h"
#include "search/frame_hypotheses.h"
#include "search/ordering.h"
#include "search/two_view.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Searches for the model that most matches agree with.
///
/// Algorithm: the options choose the parts of this loop.
///   sampler -> sample check -> minimal solver and model check -> verification (bail-out, SPRT) ->
///   if it is the best so far: degeneracy -> local optimisation -> stopping rule
///
/// Input: `best_first` are rows of `matches`, best first, for callers who know better than the descriptor
/// distances which matches to trust. Only these rows take part in the search, with PROSAC in this order. The
/// mask and the score cover all matches. Without it, all matches take part, and PROSAC orders them by their
/// distances.
///
/// Output: `result` receives the mask (matches whose error under the returned model is at most the threshold,
/// in double precision), the score (negated squared error, px^2), the model in pixels, and the number of
/// hypotheses.
///
/// Failure: without a model the mask is all zero and the status is kTooFew, kDegenerate (no valid sample, or
/// only the sample itself agrees) or kNoModel.
///
/// Time limit: at max_seconds, counted from the call, the best model so far is refined as usual and returned
/// with kTimeLimit. The status is also kTimeLimit if no hypothesis was good enough, and kTooLarge if there
/// was no time for a single one. The clock is read every 100 samples and after each new best model.
///
/// Memory: the calling thread keeps its buffers between calls.
/// @param threshold   px; options.threshold or its default
/// @param best_first  rows without repetition, or nullptr
void searchConsensus(const Correspondences& matches, const ConsensusOptions& options, double threshold,
                     Selection& result, const std::vector<std::uint32_t>* best_first = nullptr);

/// What searchModel() found.
struct SearchOutcome {
  Candidate best;                ///< normalised, with cost and inliers among the matches that took part
  int iterations = 0;            ///< hypotheses
  bool timed_out = false;        ///< whether the deadline ended the search
  bool no_valid_sample = false;  ///< whether it ended because no sample passed the check
};

/// The model with its residual that the options ask for.
TwoViewProblem problemOf(const ConsensusOptions& options);

/// The same search without a Selection, for callers with matches that are normalised already.
/// @param matches     in random order (Ordering::shuffle())
/// @param options     max_seconds is ignored
/// @param threshold   px
/// @param best_first  positions in `matches` without repetition, best first. Only these matches take part,
///                    with Sampler::kProsac, kLocal and kPnapsac in this order and with the others all alike.
///                    nullptr: all matches take part, all alike
/// @param frames      homographies that are tried before any sample, at most 60; nullptr = none. With
///                    Sampler::kFrames no samples are drawn
/// @pre at least as many matches take part as a sample has (problemOf(options).sample_size)
SearchOutcome searchModel(const NormalizedMatches& matches, const ConsensusOptions& options, double threshold,
                          const std::vector<std::uint32_t>* best_first, const Deadline& deadline,
                          FrameHypotheses* frames = nullptr);

/// Returns whether there are as many matches as a sample has. Otherwise sets the status kTooFew.
bool isEnough(std::size_t matches, const TwoViewProblem& problem, Selection& result);

/// The order in which options.sampler draws, or nullptr where it draws uniformly. Without descriptor
/// distances it does, and the message reports it.
/// @param rows        all rows of `matches`, in random order
/// @param best_first  memory of the order
const std::vector<std::uint32_t>* orderForSampler(const Correspondences& matches,
                                                  const ConsensusOptions& options,
                                                  const std::vector<std::uint32_t>& rows, Ordering& ordering,
                                                  std::vector<std::uint32_t>& best_first, Selection& result);

/// The hypotheses of Sampler::kFrames, or nullptr for other samplers. They are part of the workspace.
/// @param rows        all rows of `matches`, in random order
/// @param best_first  memory of the order
FrameHypotheses* framesForSampler(const Correspondences& matches, const ConsensusOptions& options,
                                  const std::vector<std::uint32_t>& rows, Ordering& ordering,
                                  std::vector<std::uint32_t>& best_first);

/// Writes iterations, and status and message where the search found no model or ended at the time limit.
/// @param max_seconds  the limit, s
void reportEnd(const SearchOutcome& outcome, double max_seconds, Selection& result);

/// Writes mask and score by the errors of the model that `result` has already, in double precision.
/// @param threshold  px
/// @param errors     memory; receives the squared errors of all matches, px^2
/// @return number of selected matches
std::size_t selectByModel(const Correspondences& matches, Residual residual, double threshold,
                          std::vector<double>& errors, Selection& result);

}  // namespace corrsel::core
