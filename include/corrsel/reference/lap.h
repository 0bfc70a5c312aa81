#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct LapOptions : ConfidenceOptions {
  int candidates = 25;  ///< nearest matches among which the neighbours are chosen
  int k = 10;           ///< neighbours: the candidates whose motion agrees best
  double triples_share =
      0.5;              ///< share of the triples of neighbours, the best ones, that the cost is the mean of
  double lambda = 0.8;  ///< accept if the cost is at most this
  double noise_floor = 7;  ///< motions that differ by at most this agree, px; 0 = off

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// Local affine preservation (LAP).
///
/// Idea: affine maps keep ratios of areas. Around an inlier, triangles with its neighbours have the same
/// ratios of areas in both images.
///
/// Algorithm: of the `candidates` nearest matches in the left image, the neighbours of match i are the `k`
/// ones with the largest
///   c_j = cos(v_i, v_j) / 2 + min(|v_i|^2, |v_j|^2) / max(|v_i|^2, |v_j|^2),
/// v being the motion of a match, where motions that differ by at most `noise_floor` have the largest
/// possible c = 1.5, and other motions one of which is at most `noise_floor` long have c = noise_floor / |v_i
/// - v_j|; equal ones are taken by distance. For all triples (a, b, c) of neighbours, the areas S1 = |(p_a -
/// p_i) x (p_b - p_i)|, S2 = |(p_b - p_i) x (p_c - p_i)| and S3 = |(p_a - p_i) x (p_c - p_i)| in both images
/// give
///   d = sum over the ratios S1/S2, S1/S3, S2/S3 of 1 - exp(-|ratio left - ratio right|),
/// where a ratio with a vanishing area adds 1. The cost of the left image is the mean of the smallest
/// `triples_share` of all d, that of the right image the same with the nearest matches there. A match is
/// accepted if the mean of both is at most `lambda`. There is one pass.
///
/// Input: coordinates. Equal matches are decided once.
///
/// Options: `noise_floor` is a deviation from the authors' code, for the same reason as in `lpm`: where the
/// camera rests, directions and ratios of motions are those of the localisation noise. The authors have
/// lambda = 0.7, with which fewer inliers are found where many matches are outliers.
///
/// Failure: fewer than candidates + 1 distinct matches give `too_few`; all left or all right points equal
/// give `degenerate`. The score is the cost, negated; iterations are passes.
///
/// Cost: O(N log N + N (candidates + k^3)) time, O(N candidates) memory in the workspace.
///
/// Source: Ye, Ma and Xiong, TGRS 2022, with the other constants of their fast variant. 1 - exp(-z) is read
/// from a table with an error of at most 2e-5.
class LapSelector : public SelectorWithOptions<LapOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "lap"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
