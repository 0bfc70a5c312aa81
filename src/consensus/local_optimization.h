#pragma once

#include "consensus/two_view.h"
#include "consensus/verifier.h"

namespace corrsel::core {

/// Lowers the cost of a model by least squares on its inliers (Chum, Matas and Kittler, DAGM 2003; Lebeda,
/// Matas and Chum, BMVC 2012): first with the squared threshold widened four and two times, since the inliers
/// of a minimal model are few and one-sided, then at the threshold itself until that gains less than a
/// thousandth. Never returns a worse model. O(N) per step, at most 8 steps.
void optimizeLocally(const TwoViewProblem& problem, const Verifier& verifier, Candidate& best);

}  // namespace corrsel::core
