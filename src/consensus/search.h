#pragma once

#include "corrsel/consensus/options.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Searches for the model that most matches agree with.
///
/// Algorithm: the options choose the parts of this loop.
///   sampler -> sample check -> minimal solver and model check -> verification (bail-out, SPRT) ->
///   if it is the best so far: degeneracy -> local optimisation -> stopping rule
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
/// @param threshold  px; options.threshold or its default
void searchConsensus(const Correspondences& matches, const ConsensusOptions& options, double threshold,
                     Selection& result);

}  // namespace corrsel::core
