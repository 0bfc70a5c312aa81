#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct SignificantOptions : ConfidenceOptions {
  int k = 8;                 ///< neighbours in the left image
  double deformation = 0.5;  ///< share of the distance by which the motions of neighbours may differ
  double slack = 3;          ///< differences of motion that are always tolerated, px
  double cut = 0;            ///< largest log10 of the number of false alarms of an accepted match, decades

  void visit(OptionVisitor& visitor) const override;
};

/// Locality preserving matching with a test of significance.
///
/// Idea: the neighbours of an inlier move as it does. How many of them must do so follows from the number
/// that would by chance, and not from a fixed share.
///
/// Algorithm: of the `k` matches that are nearest in the left image, m share no point with match i, that is,
/// both of their points are at least 1 px from those of i. Neighbour j agrees if the motions v differ by
/// |v_j - v_i| <= r_j = deformation |x_j - x_i| + slack. An outlier does so with the probability
/// a_j = pi r_j^2 / A2, where A2 is the area of the right image, and a is the mean of a_j. With k_i agreeing
/// neighbours among N matches
///   log10 NFA_i = log10 N + log10 P(Bin(m, a) >= k_i)
/// is the logarithm of the number of outliers that are expected to agree as well with their neighbours.
/// A match is accepted if it is below `cut`. There are two passes: in the second one, the survivors of the
/// first are the neighbours of all matches.
///
/// Input: coordinates. The size of the right image is used where it is known, otherwise the bounding box of
/// the right points. Equal matches are decided once.
///
/// Options: `deformation` = 0.5 tolerates rotations by 30 degrees and zooms by 1.5 between the images.
///
/// Failure: fewer than 4 distinct matches give `too_few`; all left or all right points equal give
/// `degenerate`. The score is -log10 NFA of the last pass, which means the same for all images; iterations
/// are passes.
///
/// Cost: O(N log N + N k) time, O(N k) memory in the workspace.
///
/// Source: own work. The neighbourhoods are those of LPM (Ma et al., IJCAI 2017), the test follows Moisan and
/// Stival, IJCV 2004.
class SignificantSelector : public SelectorWithOptions<SignificantOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "significant"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
