#pragma once

#include <string>

#include "corrsel/search/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// 10 px, 2000 hypotheses from uniform samples, and no other part of the search.
struct RansacOptions : ConsensusOptions {
  RansacOptions();
  void visit(OptionVisitor& visitor) const override;
};

/// RANSAC for a homography or a fundamental matrix: the search of search/search.h with its plain parts.
///
/// Idea: a model fitted to a few random matches is good if many other matches agree with it.
///
/// Algorithm: minimal samples (4 or 7 matches) are drawn uniformly from a seeded engine. Samples that no
/// camera could have produced (H: three collinear points, inconsistent orientation; F: equal matches, all
/// collinear) are drawn again before a model is fitted. A hypothesis replaces the best one if its cost is
/// strictly lower: MSAC, or the number of outliers. The search stops after `max_iterations` hypotheses, or
/// once ln(1 - confidence) / ln(1 - P) samples have been drawn, where P is the exact probability of an
/// all-inlier sample without replacement. The matches are first put into an order of their own, so that
/// the order of the input does not matter.
///
/// Input: coordinates; with `sampler` = `prosac` the column `distance` (and `second_distance`) or
/// `probability`, without which samples are uniform and the message reports it; with `sampler` = `frames` the
/// local affine frames (search/frame_hypotheses.h).
///
/// Options: there is no option `threads`, because each hypothesis is compared with the best one so far.
///
/// Presets: `h` and `f` choose the model. `count` scores by the number of inliers, `msac` is the default
/// score. `lo` is LO-RANSAC, `prosac` is PROSAC, and `lo_prosac` is both.
///
/// Failure: nothing is selected and the status is `too_few` (fewer matches than a sample), `degenerate`
/// (no valid sample exists, or nothing but the sample itself agrees; the model is then returned
/// unverified) or `no_model`. At `max_seconds` the best model so far is refined and returned with
/// `time_limit`. The score is the squared error in px^2, negated; iterations are hypotheses.
///
/// Cost: O(iterations * N) time, O(N) memory in the workspace.
///
/// Source: Fischler and Bolles, CACM 1981; the paper's Eqs. 2-4. MSAC: Torr and Zisserman, CVIU 2000.
/// LO-RANSAC: Chum et al., DAGM 2003. PROSAC: Chum and Matas, CVPR 2005. Deviations from OpenCV, which the
/// paper used: the score is MSAC by default, the best model is refined on its inliers, samples that the
/// check refuses count for the stopping rule, and the mask belongs to the model that is returned: exactly
/// the matches whose error under it is at most `threshold`.
class RansacSelector : public SelectorWithOptions<RansacOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "ransac"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override {
    return options_.missingInput(matches);
  }
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
