#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct GtmOptions : OptionSet {
  enum class Dynamics : std::uint8_t { kReplicator, kEquilibrium };

  double lambda = 1e-4;           ///< payoff = exp(-lambda * error), 1/px
  bool normalize_lambda = false;  ///< lambda is meant for a right image with a diagonal of 1000 px
  Dynamics dynamics = Dynamics::kReplicator;  ///< the paper uses replicator steps, see the class
  int steps = 100;                            ///< replicator: steps
  double min_share = 0.1;     ///< equilibrium: selected above this share of the largest population
  bool one_to_one = true;     ///< payoff 0 for matches that share a point
  int memory_limit = 2048;    ///< payoffs above this size are computed anew for every step, MiB
  double max_seconds = 30.0;  ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Game-theoretic matching (Albarelli et al., IJCV 2012; the paper's Eqs. 7-9).
///
/// Needs the local affine frames of both features: A_i = right_frame_i left_frame_i^-1, T_i(x) = x'_i + A_i
/// (x
/// - x_i). Payoff of two matches = exp(-lambda * max(|x'_j - T_i(x_j)|, |x'_i - T_j(x_i)|)), L1 norms: how
/// well each one predicts where the other ends. 0 on the diagonal and, with one_to_one, for matches that
/// share a point. Matches with a frame that is not finite, has no area, or is more than 10 times longer than
/// wide, or is a thousand times larger than the other one are set aside and answered with 0.
///
/// `replicator`: q_i <- q_i (Pq)_i / (q^T P q) from the uniform q, so many steps; selected where q_i > t, t
/// by Otsu's method with 256 bins over [min q, max q]. Where all q are equal (to 1e-5 per step) all matches
/// are selected if the mean payoff exceeds 1/e, else none. Few steps regularise: at convergence with this
/// lambda only a compact core is left.
///
/// `equilibrium`: an equilibrium of the game itself by infection and immunization (Rota Bulo and Bomze, Games
/// and Economic Behavior 2011), from a population spread over 1000 matches until no strategy gains more than
/// 1e-3 m (1 - m) over the mean payoff m; selected where q_i > min_share * max q. As an equilibrium of n
/// members tolerates errors of about 1 / (lambda n), lambda is meant for N = 1000 matches and scaled by 1000
/// / N.
///
/// Presets: `paper` = the default, `equilibrium` (lambda 2e-5, min_share 0.1). One match, or no two with a
/// positive payoff: nothing selected. All matches equal: degenerate. Limits: beyond memory_limit payoffs are
/// not stored, same answer, slower. At max_seconds the population so far decides, time_limit; too_large with
/// nothing selected where not even one step was done. iterations = steps. score = q_i / max q, NaN for
/// matches set aside. Replicator: payoffs as described in PairMatrix, N^2 bytes. Most populations are nearly
/// combinations of earlier ones, and so are their payoffs: 100 steps take 10 to 20 products of O(N^2),
/// payoffs being exact to 1e-6 of their mean in each step; equilibrium: O(N) time per step, a few times as
/// many steps as members, O(N) memory.
class GtmSelector : public Selector {
 public:
  explicit GtmSelector(GtmOptions options = {});
  static Presets presets();
  std::string name() const override { return "gtm"; }
  const OptionSet& options() const override { return options_; }

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  GtmOptions options_;
};

}  // namespace corrsel::core
