#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct LafOptions : ConfidenceOptions {
  int rounds = 5;            ///< rounds that run; the fifth one repeats
  double accept = 0.8;       ///< posterior above which a match is active, and finally selected
  double outlier_area = 16;  ///< area over which outliers spread, in units of the largest motion
  int min_cells = 15;        ///< cells per side at least
  int max_cells = 30;        ///< cells per side at most
  double noise_floor = 7;    ///< motions that differ by at most this agree, px; 0 = off
  bool guided = false;       ///< compute the first field from the trusted matches
  double guide_ratio = 0.9;  ///< guided: trusted matches have a distance ratio below this

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// Linear adaptive filtering.
///
/// Idea: the motion of a correct match is close to a smooth field. The field is the mean motion of the cells
/// of a grid, filtered by a small kernel. What deviates from it is removed, and the field is computed again
/// from the rest.
///
/// Algorithm: left points are divided into n_c x n_c cells over their range (with a margin of 1 %), n_c =
/// sqrt(N) between `min_cells` and `max_cells`. A motion V is the displacement, divided in each axis by the
/// largest displacement along this axis, or by 16 `noise_floor` if that is larger. The kernel is k(a, b) =
/// exp(-sqrt(a^2 + b^2)), normalised to the sum 1, with n_k = 2 round(n_c / 6) - 1 cells per side and the
/// centre weight k_0. In each round, with c active matches in a cell and their mean motion m,
///
///     W = k * c - [c > 0] k_0,    M = (k * (m c) - m k_0) / W,    d_i^2 = |V_i - M|^2,
///
/// where * is a correlation with zeros outside the grid, and M = 0 where W = 0. The matches with 1 -
/// exp(-d^2 / 0.08) < lambda have the share g and the variance s^2 = mean(d^2) / 2. A match is active in the
/// next round if its posterior
///
///     p = e / (e + 2 pi s^2 (1 - g) / (a g)),    e = exp(-d^2 / (2 s^2)),    a = outlier_area
///
/// is above `accept`. Matches that share their left or their right pixel with another match are never active,
/// but p is computed for them too. After the last round, the matches with p > accept are selected.
///
/// The rounds have lambda = 0.8, 0.2, 0.1, 0.05, 0.05.
///
/// With `guided`, only trusted matches are active in the first round: those whose ratio of descriptor
/// distances is below `guide_ratio` and the smallest one at their right pixel. Fewer than 10 trusted matches
/// are no guide.
///
/// Input: coordinates; with `guided` also the columns `distance` and `second_distance`. Motion is compared
/// within cells as a translation, so that rotations by more than about 40 degrees and strong zoom fail, as
/// with GMS.
///
/// Options: `noise_floor` is a deviation from the authors' code. Without it, localisation noise would be
/// divided by itself where no match moves along an axis. With the default, motions that differ by 7 px agree
/// in the last round. Where the sizes of the images are known, matches with a point outside do not determine
/// the scales. Two further deviations: the authors set all matches aside that share a left or a right x
/// coordinate, which on whole pixels is nearly all of them, and the variance is at least that of
/// `noise_floor` / 7.
///
/// Presets: `guided`.
///
/// Failure: fewer than 8 matches give `too_few`; all left or all right points equal give `degenerate`. If no
/// match deviates by less than lambda in a round, nothing is selected, and the message states it. If a round
/// leaves no match active, the active matches remain. The score is p; iterations are rounds.
///
/// Cost: O(N) time per round and O(n_c^2 n_k^2) for the filter, O(N) memory in the workspace.
///
/// Source: Jiang, Ma, Fan et al., Robust feature matching for remote sensing image registration via linear
/// adaptive filtering, TGRS 2020; constants of the authors' code.
class LafSelector : public SelectorWithOptions<LafOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "laf"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
