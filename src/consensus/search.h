#pragma once

#include "corrsel/consensus/options.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Searches the model that most matches agree with, by the parts that the options name:
///
///   sampler -> sample check -> minimal solver and model check -> verification (bail-out, SPRT) ->
///   where it is the best so far: degeneracy -> local optimisation -> stopping rule
///
/// The answer goes to `result`: mask = the matches whose error under the returned model is at most the
/// threshold, in double precision; score = squared error, px^2, negated; model in pixels; iterations =
/// hypotheses. No model: all zero and kTooFew, kDegenerate (no valid sample, or no more than a sample agrees)
/// or kNoModel. Uses memory of the calling thread that is kept between calls.
///
/// At max_seconds, counted from the call, the best model so far is refined as usual and returned: kTimeLimit,
/// also where no hypothesis was good enough to become a model; kTooLarge where there was no time for a single
/// one. The clock is looked at every 100 samples and after each new best model.
/// @param threshold  px; options.threshold, or what stands for it
void searchConsensus(const Correspondences& matches, const ConsensusOptions& options, double threshold,
                     Selection& result);

}  // namespace corrsel::core
