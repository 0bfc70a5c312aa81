#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "corrsel/workspace.h"

namespace corrsel::core {

/// Writes sigma and probability of a selection (match_probability.h). Computes the local support of the
/// matches, and does not depend on their order. O(N) as LocalSupport.
/// @param matches    all matches that the selector was given. Their coordinates are finite.
/// @param selection  with mask, model and confidence
void computePosterior(const Correspondences& matches, Selection& selection, Workspace& workspace);

}  // namespace corrsel::core
