#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct RfmScanOptions : ConfidenceOptions {
  double gamma = 10;               ///< weight of the motion for matches that are near each other
  double min_points_share = 0.05;  ///< share of the matches that make a neighbourhood dense
  int min_points = 3;              ///< smallest number of such matches
  int max_points = 30;             ///< largest number of such matches
  double first_epsilon = 0.1;      ///< radius of the first round, between the densest and the loneliest match
  double second_epsilon = 0.08;    ///< radius of the second round

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// RFM-SCAN: robust feature matching by density-based clusters of matches.
///
/// Idea: inliers lie close together in the space of both points and the motion, and outliers lie
/// apart. Each motion in the scene is a dense cluster, so that neither their number nor a model is needed.
///
/// Algorithm: the columns x, y, x', y', x' - x and y' - y are divided by their ranges. With the Euclidean
/// distances d1 of the left points, d2 of the right points and d3 of the motions, two matches are
///
///     D = d1 + d2 + (1 + gamma exp(-min(d1, d2))) d3
///
/// apart. M is `min_points_share` N within [`min_points`, `max_points`], and L_i is the distance of match i
/// from its M-th nearest match, where the match itself is the first. DBSCAN with the radius eps = min L +
/// `first_epsilon` (max L - min L) forms clusters: a match with at least M matches within eps is a core,
/// cores within eps of each other are in one cluster, and so are the other matches within eps of a core. A
/// second round does the same with `second_epsilon`, and there the distance to a match that is in no cluster
/// of the first round is 100 D. The matches in clusters are selected.
///
/// What is ours: the authors add random matches to data with few outliers, so that eps does not become too
/// small. Here, 20 outliers are formed of the left point of one match and the right point of another
/// one, always and without random numbers. They take part in the ranges of the motions and in max L, and in
/// nothing else. For more than 512 matches, max L is that of 512 matches, evenly drawn in the order of the
/// coordinates. If the first round finds no cluster, there is no second one.
///
/// Output: `group` has the number of the cluster, as long as there is any. The score is the number of matches
/// in the cluster, and 0 for matches in none; iterations are rounds.
///
/// Input: coordinates. Equal matches count each.
///
/// Failure: fewer than 6 matches give `too_few`; all left or all right points equal give `degenerate`. No
/// match gives an empty selection.
///
/// Cost: O(N) memory in the workspace. Matches are sorted into cells of the four-dimensional space of left
/// points and motions, whose sides are the largest d1 and d3 within the radius. A core is found after its
/// first M near matches, but an outlier is compared with all matches in the cells around it, whose number
/// grows with N, because the radius hardly shrinks. Measured: 25 to 45 ms for 5000 matches, 110 to 200 ms for
/// 20000 and 1 to 3 s for 100000, which is about N^1.5 in the end.
///
/// Source: Jiang, Ma, Jiang and Guo, Robust feature matching using spatial clustering with heavy outliers,
/// IEEE Transactions on Image Processing 2020; Ester, Kriegel, Sander and Xu, KDD 1996 (DBSCAN).
class RfmScanSelector : public SelectorWithOptions<RfmScanOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "rfm_scan"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
