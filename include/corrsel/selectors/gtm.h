#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct GtmOptions : ConfidenceOptions {
  enum class Dynamics : std::uint8_t { kReplicator, kEquilibrium };

  double lambda = 1e-4;           ///< payoff = exp(-lambda * error), 1/px
  bool normalize_lambda = false;  ///< lambda is meant for a right image with a diagonal of 1000 px
  Dynamics dynamics = Dynamics::kReplicator;  ///< the paper uses replicator steps, see the class
  int steps = 100;                            ///< replicator: steps
  double min_share = 0.1;     ///< equilibrium: selected above this share of the largest population
  bool one_to_one = true;     ///< payoff 0 for matches that share a point
  int memory_limit = 2048;    ///< payoffs above this size are computed again for every step, MiB
  int threads = 1;            ///< for large inputs; results do not depend on it
  double max_seconds = 30.0;  ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// Game-theoretic matching.
///
/// Idea: matches are the strategies of a game. Two matches pay each other the more, the better each of
/// them predicts where the other one ends. A population that plays this game ends up with matches that
/// agree.
///
/// Algorithm: with the local frames, A_i = right_frame_i left_frame_i^-1 and T_i(x) = x'_i + A_i (x -
/// x_i). The payoff of two matches is exp(-lambda * max(|x'_j - T_i(x_j)|, |x'_i - T_j(x_i)|)) in L1
/// norms. It is 0 on the diagonal and, with `one_to_one`, between matches that share a point.
///  - `replicator`: q_i <- q_i (Pq)_i / (q^T P q) from the uniform q, `steps` times. Matches with q_i > t
///    are selected, where t comes from Otsu's method with 256 bins over [min q, max q]. Where all q are
///    equal (to 1e-5 per step), all matches are selected if the mean payoff exceeds 1/e, else none. Few
///    steps regularise: at convergence, with this lambda, only a compact core is left.
///  - `equilibrium`: an equilibrium of the game by infection and immunization. It starts from a population
///    spread over 1000 matches and ends when no strategy gains more than 1e-3 m (1 - m) over the mean payoff
///    m. Matches with q_i > min_share * max q are selected. An equilibrium of n members tolerates errors of
///    about 1 / (lambda n). Therefore lambda is meant for N = 1000 matches and is scaled by 1000 / N.
///
/// Input: coordinates, the local affine frames of both features, and the size of the right image if
/// `normalize_lambda` is on. A match is set aside if a frame is not finite, has no area or is more than 10
/// times longer than wide, or if one frame is a thousand times larger than the other.
///
/// Options: `threads` speeds up the replicator from about 1800 matches on. `memory_limit` changes the time
/// and not the result.
///
/// Presets: `paper` is the default; `equilibrium` has lambda 2e-5 and min_share 0.1.
///
/// Failure: missing frames give `unsupported_input`. Nothing is selected where no two matches have a
/// positive payoff, which includes a single match. All matches equal: `degenerate`; no usable frame:
/// `degenerate`. At `max_seconds` the population so far decides and the status is `time_limit`; before the
/// first step it is `too_large`, and nothing is selected. The score is q_i / max q, NaN for matches that
/// were set aside; iterations are steps.
///
/// Cost: the replicator needs N^2 bytes (see Workspace) and O(N^2) time per product. Most populations are
/// nearly combinations of earlier ones, and so are their payoffs: 100 steps take 10 to 20 products, and
/// payoffs are exact to 1e-6 of their mean in each step. Payoffs are rounded to 16 bits (at most 7.7e-6
/// off). The equilibrium takes O(N) time per step, a few times as many steps as members, and O(N) memory.
///
/// Source: Albarelli et al., IJCV 2012; the paper's Eqs. 7-9. Equilibrium: Rota Bulo and Bomze, Games and
/// Economic Behavior 2011.
class GtmSelector : public SelectorWithOptions<GtmOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "gtm"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
