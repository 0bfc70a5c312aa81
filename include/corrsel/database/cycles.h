#pragma once

#include <cstddef>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {

/// The rotation between two images: a direction d in the frame of the first camera is R d in that of the
/// second one.
struct RelativeRotation {
  ImagePairKey pair;
  cv::Matx33d rotation = cv::Matx33d::eye();
};

/// The rotation of a verified pair with a pose, whatever its config is; none for other pairs.
std::optional<RelativeRotation> relativeRotation(const VerifiedPair& pair);

/// What the triplets say about a pair.
struct PairCycles {
  ImagePairKey pair;
  std::size_t closing = 0, failing = 0;  ///< triplets of the pair
  /// Probability that the rotation is wrong, from 0 to 1. It says nothing where there are no triplets.
  double wrong = 0;
  bool accused = false;  ///< `wrong` is above one half, and a triplet fails
};

/// Result of checkCycles().
struct CycleReport {
  std::vector<PairCycles> pairs;  ///< in ascending order
  std::size_t triplets = 0, failing = 0;
  std::size_t accused = 0;    ///< pairs
  std::size_t unchecked = 0;  ///< pairs without a triplet
  /// Noise of the closing triplets: the scale of each coordinate of the rotation by which they miss, rad; NaN
  /// without triplets.
  double noise = std::numeric_limits<double>::quiet_NaN();
  /// Triplets with a larger angle fail, rad; NaN without triplets.
  double threshold = std::numeric_limits<double>::quiet_NaN();
};

/// Finds pairs whose rotation contradicts those of other pairs.
///
/// Idea: For three images, the rotations of the pairs (i, j), (j, k) and (k, i) give the identity. Where they
/// do not, at least one of them is wrong. Which one it is shows in the other triplets of these pairs.
///
/// Algorithm: The angle a of R_ki R_jk R_ij is computed for triplets of images of which all three pairs have
/// a rotation. If all three are right, it is the length of a vector with Student's distribution in three
/// dimensions (4 degrees of freedom, because pairs are not equally accurate) and of the scale s, density
/// f(a). Otherwise it may be anything, density g(a) = c for a > s and c (a / s)^2 below. The scale of the
/// noise and the share of the triplets that close are those of the highest likelihood (EM). s is this scale,
/// and at least 0.4 degrees: precise pairs would otherwise accuse imprecise ones, whose matches are right. A
/// triplet fails where g(a) > f(a), which is from 3.4 degrees on if the noise is not larger than that.
///
/// The pairs are right or wrong, independently of each other, a priori with the probability that explains the
/// share of closing triplets. Each triplet is a factor: f(a) if its three pairs are right, and otherwise
/// g(a). Belief propagation gives the probability of every pair: 30 rounds of messages, damped by one half.
/// No triplet that closes makes a pair more suspect, so a pair is never accused without a failing one.
///
/// What it cannot find: a wrong pair without a triplet; which pair is wrong where only one triplet knows all
/// three of them; pairs that are wrong in the same way, such as those between two buildings that look alike;
/// a wrong translation, such as that of a facade shifted by a window, whose rotation is right. For a planar
/// pair with two possible poses, the wrong one may have been stored: then the pose is accused and not the
/// matches.
///
/// Cost: O(pairs * (degree of the images + max_triplets)). Memory of 28 bytes for a triplet, at most 28 *
/// max_triplets for a pair: 560 MB for a million pairs of a dense graph.
///
/// Source: C. Zach, M. Klopschitz, M. Pollefeys, Disambiguating visual relations using loop constraints, CVPR
/// 2010, with triplets only, and with scale and prior from the data.
/// @param rotations     each pair once, in any order
/// @param max_triplets  of each pair that are looked at; of more, evenly many over the third images. At
///                      least 1
/// Throws std::invalid_argument for a pair that is listed twice or of an image with itself, a matrix that is
/// no rotation, and max_triplets.
CycleReport checkCycles(std::vector<RelativeRotation> rotations, int max_triplets = 20);

}  // namespace corrsel::core
