#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/search/options.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Searches for a homography and, where it does not explain the scene, for a fundamental matrix.
///
/// Idea: the kind of model follows from what a homography leaves over (leftover.h). A scene needs a
/// fundamental matrix if matches with local support are left over in coherent groups, or if the matches off
/// the plane show parallax (parallax.h).
///
/// Algorithm: the homography is found by searchConsensus(). It is the answer if it is believed (confidence of
/// at least 4), leaves no sizable coherent group over beyond twice its threshold (beyond 10 px or the
/// threshold itself, if twice the threshold is more), and shows no parallax.
/// Otherwise the fundamental matrix is found by the same search. It is the answer if it is believed. If
/// neither is, the model with the larger confidence is the answer.
///
/// Options: options.model is not used. max_seconds holds for both searches together.
///
/// Output, Failure: as for searchConsensus() with the model chosen; the iterations of both searches count.
///
/// Cost: that of LocalSupport, of the search for a homography, and of the second search where it is needed.
/// @param homography_threshold, fundamental_threshold  px
void searchEitherModel(const Correspondences& matches, const ConsensusOptions& options,
                       double homography_threshold, double fundamental_threshold, Selection& result);

}  // namespace corrsel::core
