#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct LpmOptions : ConfidenceOptions {
  enum class Cost : std::uint8_t { kCount, kMultiscale };

  Cost cost = Cost::kCount;   ///< common neighbours only, or also their motion, at three scales
  int k = 4;                  ///< neighbours; multiscale uses k+2, k and k-2
  double lambda_first = 6.0;  ///< accept if cost <= lambda, first pass
  double lambda_second =
      6.0;                 ///< the same for the second pass, whose neighbours are the survivors of the first
  double tau = 0.2;        ///< multiscale: common neighbours whose motion agrees less than this do not count
  double noise_floor = 7;  ///< multiscale: motions that differ by at most this agree, px; 0 = off
  bool guided = false;     ///< form the first neighbourhoods from the trusted matches
  double guide_ratio = 0.9;      ///< guided: trusted matches have a distance ratio below this
  bool merge_duplicates = true;  ///< decide identical matches once, so that they cannot support themselves

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// Locality preserving matching.
///
/// Idea: a correct match keeps its neighbours. The matches around its left point are, by and large, the
/// matches around its right point.
///
/// Algorithm: `cost` is one of two measures.
///  - `count`: l = 2 (K - n), where n is the number of common neighbours of a match among the K nearest in
///    both images.
///  - `multiscale`: C = mean over K_s in {k+2, k, k-2} of (K_s - n_s + m_s) / K_s, where m_s is the number
///    of common neighbours j with cos(v_i, v_j) * min(|v_i|^2, |v_j|^2) / max(|v_i|^2, |v_j|^2) < tau and
///    |v_i - v_j| > noise_floor. v is the motion of a match. The first expression compares directions and
///    ratios of lengths, which are random where the camera rests and v is localisation noise; the second one
///    does not change the result where both motions are longer than 1.8 noise_floor (tau = 0.2).
/// A match is accepted if its cost is at most lambda. There are two passes. The second one tests all
/// matches against neighbourhoods formed by the survivors of the first, and is left out when too few
/// survive to form a neighbourhood. Neighbours at equal distance are ordered by the coordinates of the
/// matches, so that the order of the input does not matter.
///
/// With `guided`, the neighbourhoods of the first pass are formed by trusted matches: those whose ratio of
/// descriptor distances is below `guide_ratio` and the smallest one at their right point, and which survive
/// LPM among themselves (count, K 4, lambda 6, then 4). All matches form them where fewer than 10 are
/// trusted, or too few survive to form a neighbourhood.
///
/// Input: coordinates; with `guided` also the columns `distance` and `second_distance`.
///
/// Options: neighbours are taken as the authors' code does. The nearest one is always dropped as "the match
/// itself", even where it is not, and the windows of `multiscale` are the neighbours 1..8, 2..7 and 3..6.
///
/// `noise_floor` is a deviation from the authors' code. The default covers 95 % of the pairs of matches at a
/// localisation noise of 2 px per coordinate in one image, or 1.4 px in both.
///
/// Presets: `paper` is the default (K 4, lambda 6 and 6: at least one common neighbour). `v1` has lambda
/// 6, then 4. `v2` is multiscale with k 6, lambda 0.8, then 0.5, and tau 0.2. `guided` has guided = true and
/// k 6: at least three of six neighbours are common (GLPM). The authors of GLPM use K 5 and lambda 4 in the
/// last pass.
///
/// Failure: fewer distinct matches than a neighbourhood needs give `too_few`; all left or all right points
/// equal give `degenerate`. The score is the cost of the last pass, negated; iterations are passes.
///
/// Cost: O(N log N + N K^2) time for evenly spread points, O(N K) memory in the workspace.
///
/// Source: Ma et al., IJCAI 2017 (count) and IJCV 2019 (multiscale); the paper's Eqs. 24-28. Guided: GLPM, Ma
/// et al., TGRS 2018.
class LpmSelector : public SelectorWithOptions<LpmOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "lpm"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
