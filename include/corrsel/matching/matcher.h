#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct MatchOptions : OptionSet {
  bool mutual = false;                ///< keep matches whose features are nearest to each other
  double second_distance_radius = 0;  ///< px; 0 = no condition on the second nearest

  void visit(OptionVisitor& visitor) const override;
};

/// Putative matches between two images.
///
/// Idea: The right feature with the most similar descriptor is a candidate for every left feature. There is
/// no ratio test, since the selectors decide which matches are correct; the distances they need are kept.
///
/// Algorithm: Exact search by comparing all descriptors, see findNeighbours(): L2 distance (not squared) for
/// CV_32F, Hamming distance for CV_8U. Equal distances are resolved by the lowest index. Several left
/// features may have the same right feature. With `mutual`, only features that are each other's nearest are
/// matched.
///
/// Input: One descriptor per keypoint; the descriptors of both images have the same type and length.
///
/// Options: MatchOptions.
///
/// Failure: Without features on one side there are no matches. Descriptors that contain NaN are not matched.
/// The second distance is NaN where there is only one right feature, or none at second_distance_radius or
/// more from the nearest one. Throws std::invalid_argument for descriptors whose type or length differs
/// between the images, for a number of descriptors other than that of the keypoints, and for options out of
/// range.
///
/// Cost: O(N_left * N_right * D) time and O((N_left + N_right) * D) memory.
///
/// @param threads  threads that may be used; the result does not depend on it
Correspondences matchFeatures(const Features& left, const Features& right, const MatchOptions& options = {},
                              int threads = 1);

}  // namespace corrsel::core
