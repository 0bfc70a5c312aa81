#pragma once

#include "corrsel/correspondences.h"
#include "scenes.h"

namespace corrsel::performance {

/// A fixed piece of work that stands for the speed of the machine, so that the times of selectors without a
/// counterpart can be compared between machines. It does what most selectors do, and with none of the
/// package's own code, which may become faster: it sorts the matches by their left x, compares each of them
/// with the 12 next ones in this order, whose rows lie anywhere in memory, and sums single precision
/// products, quotients and roots. O(N log N).
/// @return the matches whose neighbours moved alike, so that the compiler cannot leave out the work
Mask yardstick(const core::Correspondences& matches);

}  // namespace corrsel::performance
