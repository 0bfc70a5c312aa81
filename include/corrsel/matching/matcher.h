#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct MatchOptions : OptionSet {
  bool mutual = false;                ///< keep matches whose features are nearest to each other
  double second_distance_radius = 0;  ///< px; 0 = no minimum distance of the second nearest

  void visit(OptionVisitor& visitor) const override;
};

/// Finds putative matches: the nearest right feature of every left feature, by exact brute force.
///
/// Algorithm: there is no ratio test, so several left features may have the same right one. The distance is
/// L2 (not squared) for float descriptors and Hamming for binary ones. Among equal distances the lowest index
/// wins.
///
/// Output: the matches with the distances to the first and second neighbour. Descriptors that hold NaN are in
/// no match. The second distance is NaN if there is only one right feature, or none at second_distance_radius
/// or more from the first. If one side has no features, there are no matches.
///
/// Failure: throws std::invalid_argument if type or length of the descriptors differ between the images,
/// naming both, if there are not as many descriptors as keypoints, and for options out of range.
///
/// Cost: O(N_left * N_right * D) time, O((N_left + N_right) * D) memory.
/// @param threads  number of threads that may be used; matches do not depend on it
Correspondences matchFeatures(const Features& left, const Features& right, const MatchOptions& options = {},
                              int threads = 1);

}  // namespace corrsel::core
