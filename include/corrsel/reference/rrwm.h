#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct RrwmOptions : ConfidenceOptions {
  double threshold =
      0.3;                ///< mean affinity above which all matches are selected where their values are equal
  double jump = 0.8;      ///< share of the reweighting jumps
  double inflation = 30;  ///< exponent of the jumps
  int memory_limit = 2048;    ///< affinities above this size are computed again for every product, MiB
  int threads = 1;            ///< for large inputs; results do not depend on it
  double max_seconds = 30.0;  ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Reweighted random walks for graph matching.
///
/// Idea: a random walk over the graph of pairwise agreements stays in the cluster of the inliers, and jumps
/// to a distribution in which matches that share a point compete.
///
/// Algorithm: the affinity of two matches is min(d/d', d'/d), where d and d' are the distances between their
/// points in the left and in the right image. The diagonal and the affinities of matches that share a point
/// are 0. From q = a = 1/N, up to 100 steps
///
///     q <- A ((1 - jump) q + jump a), divided by its sum,    a <- S(exp(inflation q / max q)),
///
/// are taken, until |q - q'|^2 < 1e-20 for one of the last two q'. S divides by the sum over the matches with
/// the same left point, then by the sum over those with the same right point, until a changes by less than
/// 1e-6, and finally by the sum over all. A graph matcher returns an assignment, which rejects nothing but
/// conflicts. As a selector, the matches with q_i > t are selected, where t comes from Otsu's method with 256
/// bins over [min q, max q]. Where all q are equal, all matches are selected if their mean affinity exceeds
/// `threshold`, else none. Otsu's threshold and the affinity are ours, the walk is the authors'. Their code
/// adds dummy features where the images differ in their number of features, which this one does not.
///
/// Input: coordinates.
///
/// Options: `threads` speeds up products from about 1800 matches on. `memory_limit` changes the time and not
/// the result.
///
/// Failure: nothing is selected where no two matches have a positive affinity, which includes a single match.
/// All matches equal give `degenerate`. After `max_seconds`, the distribution so far is used, and the status
/// is `time_limit`; if not even one product was done in time, it is `too_large` and nothing is selected. The
/// score is q_i / max q; iterations are products with the matrix.
///
/// Cost: O(N^2) time per product, up to 100 of them, and N^2 bytes in the workspace.
///
/// Source: Cho, Lee and Lee, Reweighted random walks for graph matching, ECCV 2010.
class RrwmSelector : public SelectorWithOptions<RrwmOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "rrwm"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
