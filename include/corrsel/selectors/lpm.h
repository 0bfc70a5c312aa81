#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct LpmOptions : OptionSet {
  enum class Cost : std::uint8_t { kCount, kMultiscale };

  Cost cost = Cost::kCount;   ///< common neighbours only, or also their motion, at three scales
  int k = 4;                  ///< neighbours; multiscale uses k+2, k and k-2
  double lambda_first = 6.0;  ///< accept if cost <= lambda, first pass
  double lambda_second =
      6.0;           ///< the same for the second pass, whose neighbours are the survivors of the first
  double tau = 0.2;  ///< multiscale: common neighbours whose motion agrees less than this do not count
  bool merge_duplicates = true;  ///< decide identical matches once, so that they cannot support themselves
  bool compat = true;            ///< the authors' neighbour handling, see the class

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// Locality preserving matching (Ma et al., IJCAI 2017 and IJCV 2019; the paper's Eqs. 24-28).
///
/// cost = `count`: l = 2 (K - n), n = common neighbours of a match among the K nearest in both images. cost =
/// `multiscale`: C = mean over K_s in {k+2, k, k-2} of (K_s - n_s + m_s) / K_s, m_s = common neighbours j
/// with cos(v_i, v_j) * min(|v_i|^2, |v_j|^2) / max(...) < tau, v being the motion (two resting matches agree
/// with 1, a resting and a moving one with 0). Two passes; the second tests all matches against the survivors
/// of the first and is left out when too few survive to form a neighbourhood.
///
/// With `compat` neighbours are taken as the authors' code does: the nearest one returned is always dropped
/// as "the match itself", even where it is not, and multiscale windows are neighbours 1..8, 2..7 and 3..6.
/// Without it a match is excluded by its number and windows start at the nearest neighbour. Neighbours at
/// equal distance are ordered by the matches' coordinates, so that the order of the input does not matter.
///
/// Presets: `paper` = the default (K 4, lambda 6 and 6: at least one common neighbour), `v1` (lambda 6, then
/// 4), `v2` (multiscale, k 6, lambda 0.8, then 0.5, tau 0.2). Fewer distinct matches than a neighbourhood
/// needs: too_few; all left or all right points equal: degenerate. score = cost of the last pass, negated.
/// O(N log N + N K^2) time for evenly spread points, O(N K) memory.
class LpmSelector : public Selector {
 public:
  explicit LpmSelector(LpmOptions options = {});
  static Presets presets();
  std::string name() const override { return "lpm"; }
  const OptionSet& options() const override { return options_; }

 protected:
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  LpmOptions options_;
};

}  // namespace corrsel::core
