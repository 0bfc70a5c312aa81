#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "auto/plane_band.h"
#include "corrsel/random.h"
#include "geometry/normalization.h"
#include "points/occupied_cells.h"
#include "search/significance.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Tests whether the matches off a plane show the parallax of a rigid scene.
///
/// Algorithm: two tests, the first one of which decides where it finds parallax.
///  1. Near the plane (plane_band.h). Pairs of the band give fundamental matrices (improveByParallax()), and
///     the best one is refined on all matches. The tolerance is two thirds of the threshold of F. There is
///     parallax if
///      - chance explains the directions of the band as little as a significant fundamental matrix:
///        log_ratio - ln(24 * 10^4) is at least 4 decades,
///      - the displacements of the band are coherent (0.3), or three quarters of it agree: where depth jumps
///        from point to point, neighbours are not alike, and
///      - the agreeing share of the band is a hundredth of the places on the plane. Less is an object, not
///        the scene.
///  2. Far from the plane. Pairs among the good matches that are farther than 3 times the threshold from the
///     plane give fundamental matrices in the same way. There is parallax if the agreement of the matches off
///     the plane is significant (significance.h), and if they are at distinct places
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
  /// @param area         of the right image, px^2
  /// @param threshold    of the fundamental matrix, px
  /// @param fundamental  receives the matrix, px, where there is parallax
  /// @return whether there is parallax
  bool find(const PlaneOfMatches& plane, double area, double threshold, std::uint64_t seed,
            cv::Matx33d& fundamental);

 private:
  struct Counts {
    double off = 0, agreeing_off = 0;  // matches; distinct places
    double on = 0, agreeing_on = 0;    // distinct places
  };

  bool findNear(const PlaneOfMatches& plane, const Verifier& verifier, double threshold, Random random,
                cv::Matx33d& fundamental);
  bool findFar(const PlaneOfMatches& plane, const Verifier& verifier, double min_agreeing_share,
               Random random, cv::Matx33d& fundamental);
  Counts count(const PlaneOfMatches& plane, const Verifier& verifier, const cv::Matx33d& fundamental);

  PlaneBand band_;
  NormalizedMatches band_matches_;
  std::vector<std::uint32_t> positions_, off_plane_;
  std::vector<float> errors_;
  std::vector<std::uint8_t> off_agreeing_, on_, on_agreeing_;
  OccupiedCells cells_;
  SignificanceTest significance_;
};

}  // namespace corrsel::core
