#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct AdalamOptions : ConfidenceOptions {
  double area_ratio = 100;        ///< area of an image over the area of the disc that a seed occupies
  double search_expansion = 4;    ///< radius of a neighbourhood over the radius of that disc
  int samples = 128;              ///< affine maps that are tried for each seed, at most
  int min_members = 6;            ///< members beyond those expected by chance that a seed needs
  double confidence = 200;        ///< members over members expected by chance
  double max_rotation = 30;       ///< largest difference of the rotations of seed and member, deg; 180 = off
  double max_scale_change = 1.5;  ///< largest ratio of the scales of seed and member; 10 = off
  double max_stretch = 5;         ///< largest singular value of a map, and of its inverse
  double seed_ratio = 1;          ///< a seed's ratio of descriptor distances is at most this; 1 = any
  double min_error = 0.5;         ///< smaller errors count as this, px
  bool one_to_one = true;         ///< count every point once in the support of a map
  int seed = 0;                   ///< of the order where there are neither distances nor probabilities
  double max_seconds = 0;         ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Adaptive locally-affine matching (AdaLAM).
///
/// Idea: near an inlier the images differ by an affine map. Seeds that are spread over the image look for
/// such a map among the matches around them. How closely matches must agree with it follows from the number
/// that would agree by chance.
///
/// Algorithm: R1 and R2 are the radii of discs whose area is 1 / `area_ratio` of the left and of the right
/// image, and rho = `search_expansion` R. Matches are ordered by their ratio of descriptor distances.
///  - Seeds are the matches with no better one within R1 in the left image. There is at most one seed per
///    square of side R1 / sqrt(2); points outside of the image belong to the squares at its border.
///  - The neighbourhood of a seed: matches within rho1 of it in the left and within rho2 in the right image.
///    Where there are frames, the rotation from the left to the right frame must differ by at most
///    `max_rotation` from that of the seed, and the scale by a factor of at most `max_scale_change`. Of
///    matches with the same point, after rounding to whole px, only the best one has a vote (`one_to_one`),
///    and none has that shares a point with the seed. n is the number of votes, at most the best 1024.
///  - u and u' are the displacements from the seed, divided by rho1 and rho2. Pairs (a, b) of the best 16
///    votes give linear maps A = [u'_a u'_b] [u_a u_b]^-1, best pairs first, `samples` at most. The errors
///    are e_j = max(|A u_j - u'_j|, min_error / rho2).
///  - Outliers are spread evenly over the disc, so n e^2 of them are expected within e. The support of a
///    map is the largest number k of votes with confidence * n e_(k)^2 <= k, where e_(k) is the k-th smallest
///    error; the two votes that made the map are subtracted.
///  - The map with the largest support is fitted to its k votes by least squares, and its support is found
///    again, now without subtraction. The seed is given up if a singular value is above `max_stretch` or
///    below 1 / max_stretch. It is accepted if c = k / (n e_(k)^2) >= confidence and k (1 - 1/c) >=
///    min_members.
///  - All matches of the neighbourhood that agree with an accepted map as closely as its votes are selected,
///    and so is the seed.
///
/// The score is the largest log10 c of the accepted seeds that select the match, 0 where there is none.
///
/// Input: coordinates and the sizes of both images. Frames decide which matches belong together; without them
/// the result is a little less good, and the message reports it. Matches whose frames are singular or not
/// finite agree with nothing. Without descriptor distances, the seeds are ordered by their
/// `probability`, and without that the order is random, by `seed`; this costs several points of F, and the
/// message reports it as well. A `seed_ratio` below 1 needs the columns `distance` and `second_distance`.
///
/// Options: the authors' code takes only mutual nearest neighbours as seeds. This is no column of the input,
/// and is not needed.
///
/// Presets: `original` is as near to the authors' code as the input allows: seed_ratio 0.8, every match
/// votes, min_error 0.01 px. `recall` has confidence 50.
///
/// Failure: fewer than 6 matches give `too_few`; all left or all right points equal give `degenerate`. At
/// `max_seconds` the seeds so far decide, in the order of their quality, and the status is `time_limit`, or
/// `too_large` before the first one. Iterations are seeds.
///
/// Cost: O(N) time and memory for a given `area_ratio`.
///
/// Source: Cavalli, Larsson, Oswald, Sattler and Pollefeys, ECCV 2020. One-to-one votes, the smallest error,
/// and that the votes of a sample do not count for it replace the special cases of the authors' code for
/// repeated residuals and residuals near zero.
class AdalamSelector : public SelectorWithOptions<AdalamOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "adalam"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
