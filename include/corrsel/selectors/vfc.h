#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct VfcOptions : ConfidenceOptions {
  double beta = 0.1;               ///< width of the kernel exp(-beta d^2), d in normalised units
  double lambda = 3.0;             ///< weight of the field's smoothness
  double threshold = 0.75;         ///< accept if the posterior is above this; the paper's theta
  double inlier_ratio = 0.9;       ///< share of inliers that the EM starts from; the paper's gamma
  double outlier_area = 10.0;      ///< area over which outliers spread, normalised units; the paper's a
  double energy_change = 1e-5;     ///< stop once the energy changes by less than this share
  int max_iterations = 500;        ///< EM steps at most
  double kernel_tolerance = 1e-5;  ///< largest error of an element of the factored K, as a share of lambda s2
  int control_points = 0;          ///< 0 = all points; else that many drawn points carry the field
  bool guided = false;       ///< fit the field to the trusted matches only, then evaluate it at all matches
  double guide_ratio = 0.9;  ///< guided: trusted matches have a distance ratio below this
  double min_sigma =
      2;         ///< guided: smallest standard deviation when the field is evaluated at all matches, px
  int seed = 0;  ///< of the drawn control points
  double max_seconds = 0;  ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Vector field consensus.
///
/// Idea: correct matches move smoothly. Their displacements follow a smooth vector field; those of outliers
/// are spread evenly over an area.
///
/// Algorithm: left and right points are centred and scaled to unit root mean square, each image by itself,
/// so that translation and uniform scale cancel. An EM then finds both the smooth field f, from left
/// points x_i to displacements y_i = x'_i - x_i, and the posteriors p_i of the matches:
///  - p_i = e_i / (e_i + 2 pi s2 (1 - g) / (g a)), e_i = exp(-|y_i - f_i|^2 / (2 s2));
///  - f = K c with (K + lambda s2 P^-1) c = Y and K_ij = exp(-beta |x_i - x_j|^2);
///  - s2 = sum p |y - f|^2 / (2 sum p);
///  - g = share of matches with p > threshold, within [0.05, 0.95].
/// When the energy settles, matches with p > threshold are accepted. By default all points carry the
/// field: K = L L^T by pivoted Cholesky up to `kernel_tolerance` * lambda s2, whose rank depends on the
/// spread of the points and not on their number; then (L^T P L + lambda s2 I) w = L^T P Y and f = L w. The
/// result does not depend on the order of the matches.
///
/// With `guided`, points are normalised and the field is fitted with the trusted matches alone: those whose
/// ratio of descriptor distances is below `guide_ratio` and the smallest one at their right point. The field
/// is then evaluated at all matches: s2 is raised to `min_sigma`^2, f stays as it is, and g = share of
/// matches with p > 0.5, within [0.01, 0.95], from 0.1 by five steps. The field is fitted to all matches
/// where fewer than 10 are trusted, or all trusted points of an image are equal.
///
/// Input: coordinates; with `guided` also the columns `distance` and `second_distance`. The method is made
/// for one motion that varies smoothly over the image. Large rotations need inlier ratios above about 0.2,
/// and jumps of depth cost recall.
///
/// Options: there is no option `threads`. 5000 matches take one or two milliseconds, of which each of a
/// dozen EM steps is too short a part to be shared out.
///
/// Presets: with `sparse`, 16 control points drawn by `seed` carry the field (SparseVFC). `guided` has guided
/// = true and lambda 6: where few matches are inliers, outliers among the trusted matches bend a stiffer
/// field less.
///
/// Failure: fewer than 5 matches give `too_few`; all left or all right points equal give `degenerate`. At
/// `max_seconds` the posteriors under the last field that was fitted decide, and the status is
/// `time_limit`; where no field was fitted, it is `too_large` and nothing is selected. The score is the
/// posterior; iterations are EM steps.
///
/// Cost: O(N (log N + rank^2 * steps)) time and O(N * rank) memory in the workspace; the rank is 15 to 40
/// for points spread over an image. With `guided`, the steps take the number of trusted matches in place of
/// N.
///
/// Source: Ma et al., TIP 2014; the paper's Eqs. 11-16. SparseVFC: Ma et al., Pattern Recognition 2013.
class VfcSelector : public SelectorWithOptions<VfcOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "vfc"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
