#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct MatchOptions : OptionSet {
  bool mutual = false;                ///< keep matches whose features are nearest to each other
  double second_distance_radius = 0;  ///< px; 0 = the second nearest, wherever it is

  void visit(OptionVisitor& visitor) const override;
};

/// Putative matches: the nearest right feature of every left feature, exact brute force, no ratio test
/// (many-to-one is normal), with first and second distance; see findNeighbours(). L2 for float descriptors
/// (not squared), Hamming for binary ones; equal distances go to the lowest index. Descriptors that hold NaN
/// are in no match. One right feature only, or with second_distance_radius none so far from the first: second
/// distance NaN. No features on one side: no matches. Throws std::invalid_argument for descriptors whose type
/// or length differ between the images, naming both, for a number of descriptors other than that of the
/// keypoints, and for options out of range. O(N_left * N_right * D) time, O((N_left + N_right) * D) memory.
/// @param threads  that may be used; matches do not depend on it
Correspondences matchFeatures(const Features& left, const Features& right, const MatchOptions& options = {},
                              int threads = 1);

}  // namespace corrsel::core
