#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct IcfOptions : ConfidenceOptions {
  double beta = 0.5;             ///< width of the kernel exp(-beta d^2), d in normalised units
  double lambda = 0.01;          ///< weight of the smoothness
  double epsilon = 2;            ///< errors below this have the same weight, px
  double first_threshold = 160;  ///< largest error in the first round, px
  double last_threshold = 5;     ///< largest error in the last round and of a selected match, px
  int rounds = 5;                ///< rounds of fitting and removing
  double max_seconds = 0;        ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// ICF: identifying point correspondences by a correspondence function, in a reduced form.
///
/// Idea: a smooth function f takes left points to right ones, and another one, g, takes right points to left
/// ones. A correct match agrees with both.
///
/// Algorithm: f is a sum of an affine function and of kernels exp(-beta d^2) at the left points, where d is a
/// distance in units of the root of the mean squared radius. It minimises
///
///     sum of max(epsilon, |f(x_i) - x'_i|) + lambda |kernel part|^2
///
/// by four steps of reweighted least squares with the weights 1 / max(|f(x_i) - x'_i|, epsilon), where lambda
/// is in units of the mean weight, so that the unit of the coordinates does not matter. g is fitted
/// likewise to the exchanged points. In each round, both are fitted to the active matches, at first all, and
/// those with errors of f and of g below a threshold remain active. The thresholds fall from
/// `first_threshold` to `last_threshold` as a geometric sequence. In the end, both are fitted to what is
/// left, and all matches with both errors below `last_threshold` are selected.
///
/// What is the authors': the two correspondence functions, the removal in rounds, and regression with an
/// epsilon-insensitive loss. What is ours: they use support vector regression, for which reweighted least
/// squares on a factor of the kernel matrix stand here; they treat the two directions differently; and all
/// constants, because those of the paper were not available. The method locks onto one smooth motion, and vfc
/// supersedes it.
///
/// Input: coordinates.
///
/// Failure: fewer than 5 matches give `too_few`; all left or all right points equal give `degenerate`. If
/// fewer than 5 matches remain in a round, nothing is selected, and the message states it. At `max_seconds`,
/// the matches that are still active are selected, and the status is `time_limit`; before the end of the
/// first round it is `too_large`, and nothing is selected. The score is the larger one of the two errors,
/// negated; iterations are rounds.
///
/// Cost: O(N r^2) time per fit, 8 or 10 of them for every round, with r of 20 to 100 kernels; O(N r) memory
/// in the workspace.
///
/// Source: Li and Hu, Rejecting mismatches by correspondence function, IJCV 2010.
class IcfSelector : public SelectorWithOptions<IcfOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "icf"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
