#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct RanksOptions : ConfidenceOptions {
  int k = 15;                   ///< neighbours of a match; the scales have k, k - 2 and k - 4
  double lambda_first = 0.8;    ///< the first pass accepts a match if its cost is at most this
  double lambda_second = 0.35;  ///< the same for the second and the third pass

  void visit(OptionVisitor& visitor) const override;
};

/// Multi-scale top K rank preservation (mTopKRP).
///
/// Idea: an inlier keeps its neighbours and the order of their distances.
///
/// Algorithm: the lists of the K nearest matches in the left and in the right image, a match itself included,
/// are rankings, for K = k + 1, k - 1 and k - 3. The c common members have the ranks p and q = 1 .. c among
/// the common ones of the left and of the right list. The cost is the mean over the three scales of
///   (sum |p - q| / min(p, q) + 2 (K - c) f) / F,   F = 2 z - 2 K,   f = F / (2 K),
///   z = K - 4 floor(K / 2) + 2 (K + 1) sum of 1 / t over t = 1 .. floor(K / 2).
/// F is that of lists without a common member and twice that of reversed lists, f that of a member without a
/// partner. A match is accepted if its cost is at most lambda. There are three passes; from the second one
/// on, the neighbours are the survivors of the pass before. A pass is left out when too few survive to form a
/// list.
///
/// Input: coordinates. Equal matches are decided once.
///
/// Failure: fewer than k + 2 distinct matches give `too_few`; all left or all right points equal give
/// `degenerate`. The score is the cost of the last pass, negated; iterations are passes.
///
/// Cost: O(N log N + N k^2) time, O(N k) memory in the workspace.
///
/// Source: Jiang, Jiang, Fan, Wang and Ma, TGRS 2019, with the constants of their code.
class RanksSelector : public SelectorWithOptions<RanksOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "ranks"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
