#pragma once

#include "geometry/rays.h"
#include "kernels/pose.h"

namespace corrsel::core {

/// The columns of the rays as the kernels take them.
inline MatchRays matchRaysOf(const RayMatches& matches) {
  static_assert(MatchRays::kColumns == Rays::kColumns, "the same columns");
  MatchRays columns;
  for (std::size_t c = 0; c < Rays::kColumns; ++c) {
    columns.left[c] = matches.left.column[c].data();
    columns.right[c] = matches.right.column[c].data();
  }
  columns.size = matches.size();
  return columns;
}

}  // namespace corrsel::core
