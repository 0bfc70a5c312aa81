#pragma once

#include <string>

#include "corrsel/consensus/options.h"
#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// All parts of the search on, with the paper's 850000 hypotheses.
struct UsacOptions : ConsensusOptions {
  UsacOptions();
  void visit(OptionVisitor& visitor) const override;
};

/// USAC, the universal framework for random sample consensus (Raguram, Chum, Pollefeys, Matas and Frahm, PAMI
/// 2013): PROSAC sampling, sample and model checks, SPRT verification, DEGENSAC, local optimisation, and a
/// stopping rule that accounts for what the SPRT loses. The parts and where each comes from: consensus/*.h.
///
/// Errors: symmetric transfer d1^2 + d2^2 (homography), Sampson distance (fundamental matrix); compared with
/// the squared threshold (the paper prints the Sampson distance against t_F: read t_F^2). threshold 0 stands
/// for the paper's 10 px and 1.5 px. Deviations from USAC 1.0: MSAC score; the SPRT is designed for the
/// smallest inlier ratio that is to be found, with the times of this implementation, and never loses more
/// than one right model in eight (consensus/sprt.h); models from local optimisation are scored in full;
/// degenerate samples are recognised by sqrt(3) times the user's threshold; PROSAC stops early only by a
/// prefix of at least one match in twenty (homography) or half of them (fundamental matrix); no descriptor
/// distances: uniform samples, and the message says so.
///
/// Presets: `h`, `f` choose the model; `uniform` samples uniformly. Statuses and score as RansacSelector.
/// O(iterations + N * best models) time on average, O(N) memory.
class UsacSelector : public Selector {
 public:
  explicit UsacSelector(UsacOptions options = {});
  static Presets presets();
  std::string name() const override { return "usac"; }
  const OptionSet& options() const override { return options_; }

 protected:
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  UsacOptions options_;
};

}  // namespace corrsel::core
