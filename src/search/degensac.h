#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/random.h"
#include "search/model.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Makes fundamental matrices from a plane and pairs of matches off the plane, and keeps the best one.
///
/// Algorithm: with H the homography of the plane, each pair gives
///   F = [e']_x H with e' = (Hx1 x x1') x (Hx2 x x2').
/// Pairs are drawn uniformly, until one pair of inliers of the best F has been drawn with probability 0.99,
/// and max_pairs at most.
///
/// Cost: the verification of max_pairs models at most, most of them given up early.
///
/// Source: Chum, Werner and Matas, CVPR 2005.
/// @param verifier   scores the fundamental matrices (Residual::kSampson)
/// @param plane      the homography, normalised like the verifier's matches
/// @param off_plane  positions of the matches to draw pairs from; at least two
/// @param best       the model to beat; a default Candidate if there is none
/// @return whether `best` was replaced
bool improveByParallax(const Verifier& verifier, const cv::Matx33d& plane,
                       const std::vector<std::uint32_t>& off_plane, int max_pairs, Random& random,
                       Candidate& best);

/// DEGENSAC: recovers from samples that lie mostly on one plane.
///
/// Idea: if five or more of the seven matches of a sample lie on one plane, the fundamental matrix agrees
/// with everything on the plane and with little else. The plane and two matches off the plane give a better
/// one.
///
/// Algorithm: each of the triplets {1,2,3}, {4,5,6}, {1,2,7}, {4,5,7}, {3,6,7} of the sample determines,
/// together with F, a homography. The sample is degenerate if at least five of its matches agree with one of
/// them within sqrt(3) times the threshold. This homography is refined on all matches. The plane and pairs of
/// matches off the plane (farther than 3 times the threshold) then give fundamental matrices, as
/// improveByParallax() makes them.
///
/// Cost: O(N) if the sample is degenerate (at most 500 pairs, most of them given up early), otherwise O(1).
///
/// Source: Chum, Werner and Matas, CVPR 2005.
/// @param best  made from `sample`; replaced if plane and parallax give a better one
/// @return whether it was replaced
bool escapeDominantPlane(const Verifier& verifier, const std::uint32_t* sample, DegeneracyMemory& memory,
                         Candidate& best);

}  // namespace corrsel::core
