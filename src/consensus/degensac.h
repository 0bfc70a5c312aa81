#pragma once

#include <cstdint>
#include <vector>

#include "consensus/two_view.h"
#include "consensus/verifier.h"
#include "corrsel/random.h"

namespace corrsel::core {

/// DEGENSAC (Chum, Werner and Matas, CVPR 2005): a fundamental matrix from seven matches of which five or
/// more lie on one plane agrees with everything on the plane and with little else.
///
/// escape() looks for such a plane through the five triplets {1,2,3}, {4,5,6}, {1,2,7}, {4,5,7}, {3,6,7} of
/// the sample: each fixes, with F, a homography; the sample is degenerate where at least five of its matches
/// agree with it within sqrt(3) times the threshold. The homography then is refined on all matches, and pairs
/// of matches off the plane (farther than 3 times the threshold) give fundamental matrices F = [e']_x H, e' =
/// (Hx1 x x1') x (Hx2 x x2').
class Degensac {
 public:
  /// Memory that is worth keeping between searches.
  struct Scratch {
    std::vector<float> errors;
    std::vector<std::uint32_t> off_plane;
  };

  /// @param seed     of the pairs
  /// @param scratch  must outlive this object
  Degensac(std::uint64_t seed, Scratch& scratch) : random_(seed), scratch_(scratch) {}

  /// Replaces `best`, the model made from `sample`, where plane and parallax give a better one. @return
  /// whether they did. O(N) where the sample is degenerate (at most 500 pairs, most of them given up early),
  /// O(1) otherwise.
  bool escape(const Verifier& verifier, const std::uint32_t* sample, Candidate& best);

 private:
  Random random_;
  Scratch& scratch_;
};

}  // namespace corrsel::core
