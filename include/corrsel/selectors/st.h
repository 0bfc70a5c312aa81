#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct StOptions : ConfidenceOptions {
  enum class Affinity : std::uint8_t { kRatio, kDifference };

  Affinity affinity =
      Affinity::kRatio;             ///< of distances: their ratio (the paper) or difference, see the class
  double threshold = 0.3;           ///< affinities up to this conflict; negative: none do
  double sigma = 5.0;               ///< difference: the affinity is zero from 3 sigma on, px
  double duplicate_affinity = 1.0;  ///< ratio: affinity of two equal matches, 0/0 by the formula
  double noise_floor = 0.0;   ///< distances that differ by no more than this do not conflict, px; 0 = off
  bool one_to_one = false;    ///< matches that share a point in one image only conflict
  int memory_limit = 2048;    ///< affinities above this size are computed again for every product, MiB
  int threads = 1;            ///< for large inputs; results do not depend on it
  double max_seconds = 30.0;  ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Spectral technique.
///
/// Idea: correct matches agree with one another in pairs. In the matrix of these agreements they form a
/// cluster, which the principal eigenvector marks.
///
/// Algorithm: d and d' are the distances between the points of two matches in the left and in the right
/// image.
///  - Affinity `ratio`: min(d/d', d'/d), the paper's; 0 where one of both distances is 0.
///  - Affinity `difference`: max(0, 1 - (d - d')^2 / (9 sigma^2)), which is Leordeanu and Hebert's 4.5 -
///    (d - d')^2 / (2 sigma^2) up to a factor that changes nothing.
/// The diagonal is 0, and v is the non-negative principal eigenvector. The greedy step selects the match
/// with the largest v_i > 0 among those left and drops those in conflict with it, again and again. Equal
/// v_i are taken in the order of their coordinates. v comes from a Lanczos process, started at the
/// constant vector and with all vectors kept orthogonal, until |A v - r v| <= 1e-6 r |v|. Entries below
/// 1e-5 of the largest count as zero. Affinities are rounded to 16 bits (at most 7.7e-6 off); conflicts
/// are decided in full precision.
///
/// Input: coordinates.
///
/// Options: `threads` speeds up products and conflicts from about 1800 matches on. `memory_limit` changes
/// the time and not the result.
///
/// Presets: `leordeanu_hebert` has the affinity `difference`, and only matches that share one point
/// conflict.
///
/// Failure: nothing is selected where no two matches have a positive affinity, which includes a single
/// match. All matches equal: the rule applies, by which all are selected unless options change it, and the
/// status is `degenerate`. The time that the first product took is reserved for the greedy step. Where the
/// rest of `max_seconds` is over, that step works on the best vector so far, and the status is
/// `time_limit`; if not even one product was done in time, it is `too_large` and nothing is selected. The
/// score is v_i / max v; iterations are products with the matrix.
///
/// Cost: O(N^2) time per product, usually 5 to 8 of them, and N^2 bytes (see Workspace).
///
/// Source: Leordeanu and Hebert, ICCV 2005; the paper's section on ST.
class StSelector : public SelectorWithOptions<StOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "st"; }
  Presets presets() const override;

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
