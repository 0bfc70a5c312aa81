#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct StOptions : OptionSet {
  enum class Affinity : std::uint8_t { kRatio, kDifference };

  Affinity affinity =
      Affinity::kRatio;             ///< of distances: their ratio (the paper) or difference, see the class
  double threshold = 0.3;           ///< affinities up to this conflict; negative: none do
  double sigma = 5.0;               ///< difference: the affinity is zero from 3 sigma on, px
  double duplicate_affinity = 1.0;  ///< ratio: affinity of two equal matches, 0/0 by the formula
  double noise_floor = 0.0;   ///< distances that differ by no more than this do not conflict, px; 0 = off
  bool one_to_one = false;    ///< matches that share a point in one image only conflict
  int memory_limit = 2048;    ///< affinities above this size are computed anew for every product, MiB
  double max_seconds = 30.0;  ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Spectral technique (Leordeanu and Hebert, ICCV 2005; the paper's section on ST).
///
/// Affinity of two matches whose points are d apart in the left image and d' in the right one: `ratio` =
/// min(d/d', d'/d) (the paper; 0 where one of both is 0), `difference` = max(0, 1 - (d - d')^2 / (9
/// sigma^2)), which is Leordeanu and Hebert's 4.5 - (d - d')^2 / (2 sigma^2) up to a factor that changes
/// nothing. The diagonal is 0. v is the non-negative principal eigenvector. Greedily, the match with the
/// largest v_i > 0 among those left is selected and those in conflict with it are dropped; equal v_i in the
/// order of their coordinates.
///
/// v comes from a Lanczos process started at the constant vector, with all vectors kept orthogonal, until
/// |A v - r v| <= 1e-6 r |v|; entries below 1e-5 of the largest count as zero. iterations = products with A.
/// Affinities are stored as described in PairMatrix; conflicts are decided in full precision.
///
/// Preset: `leordeanu_hebert` = difference, conflicts one-to-one only. No two matches with a positive
/// affinity, and so one match alone: nothing selected. All matches equal: the rule applies, by default all
/// are selected, degenerate. Limits: beyond memory_limit the affinities are not stored, same answer, slower.
/// Short of max_seconds, by the time that the first product took, the greedy step works on the best vector so
/// far, time_limit; too_large with nothing selected where not even one product was done in time. score = v_i
/// / max v. O(N^2) time per product, usually 5 to 8, N^2 bytes.
class StSelector : public Selector {
 public:
  explicit StSelector(StOptions options = {});
  static Presets presets();
  std::string name() const override { return "st"; }
  const OptionSet& options() const override { return options_; }

 protected:
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  StOptions options_;
};

}  // namespace corrsel::core
