#pragma once

#include "search/model.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Lowers the cost of a hypothesis by least squares on its inliers.
///
/// Algorithm: the inliers of a minimal model are few and one-sided. The first two steps therefore multiply
/// the squared threshold by four and by two. The following steps use the threshold itself, until a step
/// lowers the cost by less than a thousandth. A worse hypothesis is never returned.
///
/// Cost: O(N) per step, at most 8 steps.
///
/// Source: Chum, Matas and Kittler, DAGM 2003; Lebeda, Matas and Chum, BMVC 2012.
void optimizeLocally(const Model& model, const Verifier& verifier, Candidate& best);

}  // namespace corrsel::core
