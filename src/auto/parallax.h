#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/random.h"
#include "geometry/normalization.h"
#include "points/occupied_cells.h"
#include "points/place_index.h"
#include "search/significance.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Tests whether the matches off a plane show the parallax of a rigid scene.
///
/// Idea: the inliers of a plane that a homography misses by little are displaced from it by noise, in any
/// direction. Points of a rigid scene are displaced along their epipolar lines, all of which meet in one
/// epipole. Wrong matches are rarely displaced by little, so a few right ones stand out there, however many
/// wrong ones there are elsewhere.
///
/// Algorithm: two tests, the first one of which decides where it finds parallax.
///  1. Near the plane. The band are the matches that the plane misses by 0.6 to 5 times its threshold, at
///     distinct places, where descriptors are known only those that are as good as the better three quarters
///     of the matches on the plane. Pairs of them give fundamental matrices (improveByParallax()), and the
///     best one is refined on all matches. A displacement in a random direction is within t of the epipolar
///     line with the probability p = 2/pi asin(t sqrt(1 + (n_l / n_r)^2) / r), where r is its length, n_l and
///     n_r are the lengths of the normals of both epipolar lines, and t, a Sampson distance, is two thirds of
///     the threshold of F. If a share s of the band follows its lines, the log likelihood ratio to random
///     directions is
///       G = max over s of  sum over the agreeing ln((s + (1 - s) p) / p) + sum over the others ln(1 - s).
///     There is parallax if chance explains G as little as a significant fundamental matrix, that is if
///     G - ln(24 * 10^4) is at least 4 decades, and if the agreeing share s of the band is at least a
///     hundredth of the places on the plane. A smaller one is an object, not the scene.
///  2. Far from the plane, where depth jumps from point to point. Pairs among the good matches that are
///     farther than 3 times the threshold from the plane give fundamental matrices in the same way. There is
///     parallax if the agreement of the matches off the plane is significant (significance.h), and if they
///     are at distinct places
///      - half as many as the matches on the plane, and a tenth of all matches off the plane, or
///      - 1.25 times as many as those on the plane, and 8 times as many as chance gives.
///     Repeated structure makes up to 6 % of the matches off a plane agree, and some of it is significant.
/// In both tests, half of the matches on the plane must agree with the fundamental matrix, too.
///
/// Cost: O(N) and that of at most 300 pairs for each test; memory is kept between calls.
///
/// Source: plane and parallax: Chum, Werner and Matas, CVPR 2005. The tests are this package's own.
class ParallaxTest {
 public:
  struct Input {
    const Correspondences& pixels;                 ///< in random order
    const NormalizedMatches& matches;              ///< the same, normalised
    const std::vector<std::uint32_t>& best_first;  ///< positions, best first
    bool ranked;                                   ///< whether their order comes from descriptors
    const cv::Matx33d& plane;                      ///< its homography, normalised like the matches
    const std::vector<double>& errors;             ///< squared errors of all matches under the plane, px^2
    double area;                                   ///< of the right image, px^2
    double homography_threshold, fundamental_threshold;  ///< px
    std::uint64_t seed;
  };

  /// @param fundamental  receives the matrix, px, where there is parallax
  /// @return whether there is parallax
  bool find(const Input& input, cv::Matx33d& fundamental);

 private:
  struct Counts {
    std::size_t off = 0;  // matches
    double agreeing_off = 0, on = 0, agreeing_on = 0;  // distinct places
  };

  bool findNear(const Input& input, const Verifier& verifier, cv::Matx33d& fundamental);
  bool findFar(const Input& input, const Verifier& verifier, cv::Matx33d& fundamental);
  void gatherBand(const Input& input);
  double directionEvidence(const Input& input, const cv::Matx33d& fundamental, double& share) const;
  Counts count(const Input& input, const Verifier& verifier, const cv::Matx33d& fundamental, double far);

  std::vector<std::uint32_t> band_, positions_, off_plane_;
  NormalizedMatches band_matches_;
  PlaceIndex left_places_, right_places_;
  std::vector<float> errors_;
  std::vector<std::uint8_t> off_agreeing_, on_, on_agreeing_;
  OccupiedCells cells_;
  SignificanceTest significance_;
};

}  // namespace corrsel::core
