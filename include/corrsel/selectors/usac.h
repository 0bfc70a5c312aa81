#pragma once

#include <string>

#include "corrsel/search/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// All parts of the search on, with the smaller transfer error and every image point counted once.
struct UsacOptions : ConsensusOptions {
  UsacOptions();
  void visit(OptionVisitor& visitor) const override;
};

/// USAC, the universal framework for random sample consensus.
///
/// Idea: random sample consensus in which each step is done by the best known part: PROSAC sampling,
/// checks of samples and models, SPRT verification, DEGENSAC, local optimisation, and a stopping rule that
/// accounts for what the SPRT loses.
///
/// Algorithm: the search of search/search.h; the headers in src/search describe each part with its
/// equations. A match is selected if the smaller one of its two transfer errors (homography) or its Sampson
/// distance (fundamental matrix) is at most the threshold. Homographies compete by the symmetric transfer
/// error d1^2 + d2^2 within twice the threshold (search/homography_model.h). (The paper prints the Sampson
/// distance against t_F: read t_F^2.)
///
/// Input: coordinates; for PROSAC the column `distance` (and `second_distance`) or `probability`, without
/// which samples are uniform and the message reports it; with `sampler` = `frames` the local affine frames.
///
/// Options: `threshold` 0 means 5 px (homography; the paper's 10 px with another `error`) the paper's
/// 1.5 px (fundamental matrix) and 1 px (essential matrix). `max_iterations` 0 means 60000 (homography) or
/// 40000 (fundamental matrix) or 20000 (essential matrix), so that random matches, where nothing ends the
/// search before, take less than 0.1 s. There is no option `threads`, because each hypothesis is compared
/// with the best one so far.
///
/// Presets: `h`, `f` and `e` choose the model; `uniform` samples uniformly; `frames` takes homographies from
/// single matches in place of samples; `paper` has the paper's error, threshold and number of hypotheses, and
/// counts every match.
///
/// Failure: statuses and score as for RansacSelector.
///
/// Cost: O(iterations + N * best models) time on average, O(N) memory in the workspace.
///
/// Source: Raguram, Chum, Pollefeys, Matas and Frahm, PAMI 2013. Deviations from USAC 1.0:
///  - The score is MSAC.
///  - The SPRT is designed for the smallest inlier ratio that the search can find, with the times of this
///    implementation, and never loses more than one good model in eight (search/sprt.h).
///  - PROSAC for a homography soon reaches all matches; samples from short and long prefixes then take turns
///    (search/prosac_proposal.h).
///  - From the 2000th hypothesis on, the best of every 100 gets inner samples (search/inner_sampling.h).
///  - The search ends once every support that chance does not explain would have been drawn.
///  - Models from local optimisation are scored in full.
///  - Degenerate samples are recognised by sqrt(3) times the user's threshold.
///  - PROSAC stops early only by a prefix of at least one match in twenty (homography) or half of them
/// (fundamental matrix).
class UsacSelector : public SelectorWithOptions<UsacOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "usac"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override {
    return options_.missingInput(matches);
  }
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
