#pragma once

#include <string>

#include "corrsel/consensus/options.h"
#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// The defaults are those of ConsensusOptions: 10 px, 2000 hypotheses, the plain parts.
struct RansacOptions : ConsensusOptions {
  void visit(OptionVisitor& visitor) const override;
};

/// RANSAC (Fischler and Bolles, CACM 1981; the paper's Eqs. 2-4) for a homography or a fundamental matrix:
/// the search of consensus/search.h with its plain parts.
///
/// Uniform minimal samples (4 or 7 matches) from a seeded engine; samples that no camera could have produced
/// (H: three collinear points, inconsistent orientation; F: equal matches, all collinear) are drawn again
/// before a model is fitted. A hypothesis replaces the best one if its cost is strictly lower: MSAC (Torr and
/// Zisserman, CVIU 2000), or the number of outliers. The search stops after max_iterations hypotheses, or
/// once ln(1-p)/ln(1-P) samples have been drawn, P being the exact probability of an all-inlier sample
/// without replacement.
///
/// Deviations from OpenCV, which the paper used: MSAC score by default, the best model is refined on its
/// inliers, the samples refused by the check count for the stopping rule, and the mask belongs to the model
/// that is returned: exactly the matches whose error under it is <= threshold. The matches are put into an
/// order of their own before any are drawn: the order of the input does not matter.
///
/// Presets: `h`, `f` choose the model; `count` scores by inliers; `msac` (the default); `lo` = LO-RANSAC
/// (Chum et al., DAGM 2003); `prosac` (Chum and Matas, CVPR 2005). No model: all zero and too_few (fewer
/// matches than a sample), degenerate (no valid sample exists, or nothing but the sample itself agrees: the
/// model is returned unverified) or no_model. score = squared error in px^2, negated. O(iterations * N) time,
/// O(N) memory.
class RansacSelector : public Selector {
 public:
  explicit RansacSelector(RansacOptions options = {});
  static Presets presets();
  std::string name() const override { return "ransac"; }
  const OptionSet& options() const override { return options_; }

 protected:
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  RansacOptions options_;
};

}  // namespace corrsel::core
