#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "geometry/normalization.h"
#include "points/occupied_cells.h"
#include "search/significance.h"

namespace corrsel::core {

/// Tests whether the matches off a plane show the parallax of a rigid scene.
///
/// Idea: where the depth jumps from point to point, hardly any match has local support, and a plane leaves
/// nothing coherent over. But a plane and two matches off it determine the epipolar geometry, and many other
/// matches off the plane then agree with it.
///
/// Algorithm: pairs among the good matches that are farther than 15 px from the plane give fundamental
/// matrices (improveByParallax()), and the best one is refined on all matches. Of all matches farther than
/// 15 px from the plane, those are counted that agree with it, at distinct places (occupied_cells.h). There
/// is parallax if half of the matches on the plane agree with it, too, and if the count
///  - is at least 40 times the one expected by chance, and half the number of matches on the plane, or
///  - is significant among the matches off the plane (significance.h), and 1.25 times the number on the
///  plane.
/// Repeated structure makes 4 to 12 times as many matches agree as chance does, and some of it is
/// significant, but it does not outnumber a plane. The share of matches that agree by chance is 2 sqrt(2) t /
/// sqrt(area) for a threshold t.
///
/// Cost: that of improveByParallax() with 300 pairs, and O(N); memory is kept between calls.
class ParallaxTest {
 public:
  struct Thresholds {
    double homography, fundamental;  // px
  };

  /// @param pixels      the matches, in random order
  /// @param matches     the same, normalised
  /// @param best_first  positions in `matches`, best first; pairs come from the best max(100, N / 8)
  /// @param plane       its homography, normalised like the matches
  /// @param errors      squared errors of all matches under the plane, px^2
  /// @param area        of the right image, px^2
  /// @param fundamental receives the matrix, px
  /// @return whether there is parallax
  bool find(const Correspondences& pixels, const NormalizedMatches& matches,
            const std::vector<std::uint32_t>& best_first, const cv::Matx33d& plane,
            const std::vector<double>& errors, double area, const Thresholds& thresholds, std::uint64_t seed,
            cv::Matx33d& fundamental);

 private:
  std::vector<std::uint32_t> off_plane_;
  std::vector<float> errors_;
  std::vector<std::uint8_t> off_agreeing_, on_, on_agreeing_;
  OccupiedCells cells_;
  std::vector<std::uint32_t> far_;
  SignificanceTest significance_;
};

}  // namespace corrsel::core
