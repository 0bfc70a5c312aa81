#pragma once

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/motion_guess.h"
#include "corrsel/options.h"

namespace corrsel::core {

/// Lengths are in thousandths of the diagonal of the right image, beyond what the uncertainty of the rotation
/// (three standard deviations) adds.
struct GuidedOptions : OptionSet {
  double radius = 48;  ///< of the area in which a match is looked for; the parallax must be smaller
  double band = 8;     ///< half the width of the band along the epipolar line of a known translation

  void visit(OptionVisitor& visitor) const override;
};

/// What matchGuided() found.
struct GuidedMatches {
  Correspondences matches;
  GuessVerdict verdict = GuessVerdict::kNone;  ///< kConfirmed: the matches are those near predicted places
};

/// Putative matches between two images of calibrated cameras whose motion is believed to be known.
///
/// Idea: a rotation moves every feature to a known place, and a translation moves it from there along a known
/// line. Few right features are near that place, so most comparisons of descriptors can be left out, and
/// similar features elsewhere cannot be confused with the right one. What is believed may be wrong, so it is
/// tested first, by features that are compared with all others.
///
/// Algorithm:
///  1. The ray of every left feature is turned by the rotation and projected into the right camera. Its area
///     is the circle with `radius` about this place or, where the translation is known, the band with a half
///     width of `band` along the epipolar line from this place (infinite depth) to the epipole (depth 0).
///     Features without a predicted place have no candidates.
///  2. Test: some 150 left features, the strongest in each cell of a grid, are compared with all right
///     features. Of those that pass the ratio test (0.8), as many have their nearest feature in their area
///     that chance explains it with a probability below 10^-4 (binomial distribution; the chance of a feature
///     is the share of 128 right features, spread evenly over the indices, that are in its area). They must
///     be half of all at least, and must not spread beyond the area: between it and an area of twice the
///     radius (band: with the half width `radius`) the excess over chance is at most 15 % of those in the
///     area. A translation that fails the test is left out, and the rotation is tested alone.
///  3. Left features of a cell have the same candidates: all that are in the area of one of them, and those
///     that are as near to the mean of their places. Candidates are compared as in matchFeatures(), with the
///     same distances, and with the lowest index among equal ones. `mutual` regards candidates only.
///
/// The second distance is the smallest one among the other candidates and 128 right features that are evenly
/// spread over the indices, except those at the place of the match. Without them a feature with few
/// candidates would pass every test of ratios by chance. `second_distance_radius` applies to all.
///
/// Input: as for matchFeatures(), and cameras that belong to the images as they are.
///
/// Options: MatchOptions, GuidedOptions.
///
/// Failure: where the guess fails the test, the matches are exactly those of matchFeatures(). The verdict is
/// kContradicted if the features that pass the ratio test disagree with it, and kNone if too few pass it
/// (fewer than 16, or than a tenth), if fewer than half of them agree, or if the agreeing ones spread beyond
/// the area. Throws std::invalid_argument as matchFeatures() does, and for cameras or a guess that are not
/// valid.
///
/// Cost: that of the test, about 150 N_right comparisons, plus N_left times the features in an area.
///
/// Source: own work; the homography of a rotation is that of Hartley and Zisserman, Multiple View Geometry,
/// 2nd edition, 8.4.
///
/// @param threads  threads that may be used; the result does not depend on it
GuidedMatches matchGuided(const Features& left, const Features& right, const Camera& left_camera,
                          const Camera& right_camera, const MotionGuess& guess,
                          const MatchOptions& options = {}, const GuidedOptions& guided = {},
                          int threads = 1);

}  // namespace corrsel::core
