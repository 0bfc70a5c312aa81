#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "geometry/normalization.h"
#include "points/place_index.h"

namespace corrsel::core {

/// A homography of matches, and what it leaves over.
struct PlaneOfMatches {
  const Correspondences& pixels;                 ///< in random order
  const NormalizedMatches& matches;              ///< the same, normalised
  const std::vector<std::uint32_t>& best_first;  ///< positions, best first
  bool ranked;                                   ///< whether their order comes from descriptors
  const cv::Matx33d& homography;                 ///< normalised like the matches
  const std::vector<double>& errors;             ///< squared errors of all matches under it, px^2
  double threshold;                              ///< px: up to this error a match is on the plane
};

/// The matches that a plane misses by little: which way are they displaced from it?
///
/// Idea: noise displaces the matches of a plane in any direction. Points of a rigid scene off the plane are
/// displaced along their epipolar lines, and neighbours by similar lengths. Repeated structure displaces
/// matches along its rows, too, but neighbours by different numbers of its periods. Wrong matches are rarely
/// displaced by little, so a few right ones stand out here, however many wrong ones there are elsewhere.
///
/// Algorithm: the band are the matches that the plane misses by 0.6 to 5 times its threshold, at places that
/// are 4 units (length_unit.h) apart in both images. Where descriptors are known, only those take part that
/// are as good as the better three quarters of the matches on the plane.
///
/// Cost: O(N) for gather(), O(band) for direction(), O(band), at most 40000 steps, for coherence(). Memory is
/// kept between calls.
class PlaneBand {
 public:
  /// The share of the band that is displaced along epipolar lines.
  struct Direction {
    double log_ratio = 0;  ///< evidence for it, natural logarithm of the likelihood ratio; at least 0
    double share = 0;      ///< 0 to 1
  };

  void gather(const PlaneOfMatches& plane);

  /// The band, best first: positions of matches.
  const std::vector<std::uint32_t>& members() const { return members_; }

  /// Compares displacements along the epipolar lines of F with displacements in random directions.
  ///
  /// A displacement of length r in a random direction is within t of the line with the probability
  /// p = 2/pi asin(t sqrt(1 + (n_l / n_r)^2) / r), where n_l and n_r are the lengths of the normals of both
  /// epipolar lines. If a share s of the band follows its lines, the log likelihood ratio is
  ///   max over s of  sum over the agreeing ln((s + (1 - s) p) / p) + sum over the others ln(1 - s).
  /// @param fundamental  normalised
  /// @param tolerance    t, a Sampson distance, px
  Direction direction(const cv::Matx33d& fundamental, double tolerance);

  /// How much more alike the displacements of neighbours are than those of any two matches: 1 = all are
  /// alike, 0 = no more than by chance. Considered are the first 200 members that agreed in direction(), and
  /// 4 neighbours of each in the left image. Two displacements are alike if they differ by at most 0.4 times
  /// the threshold of the plane or a quarter of the smaller one.
  double coherence() const;

 private:
  struct Displaced {
    double x, y;    // in the left image, px
    double length;  // along the epipolar line, away from the epipole, px
  };

  const PlaneOfMatches* plane_ = nullptr;
  std::vector<std::uint32_t> members_;
  PlaceIndex left_places_, right_places_;
  std::vector<double> chances_;       // of the agreeing members
  std::vector<Displaced> displaced_;  // the agreeing members
};

}  // namespace corrsel::core
