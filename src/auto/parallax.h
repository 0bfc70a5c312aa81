#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "auto/plane_band.h"
#include "geometry/normalization.h"
#include "points/occupied_cells.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Tests whether the matches off a plane show the parallax of a rigid scene.
///
/// Algorithm: Pairs of matches near the plane, 0.6 to 5 times its threshold (plane_band.h), and then pairs of
/// good matches that are farther than 3 times the threshold from the plane, give fundamental matrices
/// (improveByParallax()). The best one of each kind is refined on all matches. Half of the matches on the
/// plane must agree with it. There is parallax if the evidence is at least 3 decades. It is the sum of
///
/// - the log likelihood ratio of the directions in the band, for a tolerance of two thirds of the threshold,
/// - -log10 P(Bin(n - 2, p) >= k - 2) if k of the n matches far from the plane agree, at distinct places. p
/// is
///   the share of re-paired matches that agree, or 2 sqrt(2) t / sqrt(area) if this is larger,
/// - -log10(2 * 10^4), for two candidates from 10^4 hypotheses each, as SignificanceTest counts them at
/// least.
///
/// Repeated structure agrees with the epipolar lines of its rows. Where descriptors are known, which confuse
/// it, the band counts only if the agreeing ones are a hundredth of the matches on the plane (less is an
/// object, not the scene), and if their displacements are coherent (0.3). Where depth jumps from point to
/// point, they are not, and the plane holds by chance only. The band therefore counts, too, if five eighths
/// of it agree, as many as a fifth of the matches on the plane, and their displacements are not periodic
/// (0.65).
///
/// The matches far from the plane count only if their displacements are not periodic (0.6). Where descriptors
/// are known, they must also be half as many as the matches on the plane and 30 % of all that are far, or
/// 1.25 times as many as those on the plane and 8 times as many as chance gives. Up to 6 % of the matches off
/// the planes of real images agree with one fundamental matrix. Two parallel planes, one seen through the
/// other, look like repeated structure.
///
/// Cost: O(N) and that of at most 600 pairs; memory is kept between calls.
///
/// Source: plane and parallax: Chum, Werner and Matas, CVPR 2005. The test is this package's own.
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

  bool test(const PlaneOfMatches& plane, const Verifier& verifier, double threshold, Candidate& candidate);
  double nearEvidence(const PlaneOfMatches& plane, const cv::Matx33d& fundamental, double threshold,
                      double on);
  double farEvidence(const PlaneOfMatches& plane, const Verifier& verifier, const cv::Matx33d& fundamental,
                     double threshold, const Counts& counts);
  Counts count(const PlaneOfMatches& plane, const Verifier& verifier, const cv::Matx33d& fundamental);
  void gatherPool(const NormalizedMatches& matches, const std::vector<std::uint32_t>& pool);

  PlaneBand near_, far_;
  NormalizedMatches pool_;
  double uniform_chance_ = 0;
  std::vector<std::uint32_t> positions_, good_off_, off_;
  std::vector<float> errors_;
  std::vector<std::uint8_t> off_agreeing_, on_, on_agreeing_;
  OccupiedCells cells_;
};

}  // namespace corrsel::core
