#pragma once

#include <string>

#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct RansacOptions : OptionSet {
  std::string model = "homography";  ///< "homography" or "fundamental"
  double threshold = 10.0;     ///< inlier threshold, px: forward transfer error (H) or Sampson distance (F)
  int max_iterations = 2000;   ///< hypotheses at most
  double confidence = 0.995;   ///< probability of having drawn an all-inlier sample at which the search stops
  std::string score = "msac";  ///< "msac" (sum of truncated squared errors) or "inlier_count"
  bool refine = true;          ///< least squares on the inliers of the best hypothesis
  int seed = 0;                ///< of the sampler

  void visit(OptionVisitor& visitor) override;
};

/// RANSAC (Fischler and Bolles, CACM 1981; the paper's Eqs. 2-4) for a homography or a fundamental matrix.
///
/// Uniform minimal samples (4 or 7 matches) from a seeded engine; samples that no camera could have produced
/// (H: three collinear points, inconsistent orientation; F: equal matches, all collinear) are redrawn before
/// a model is fitted. A hypothesis replaces the best one if its MSAC cost (Torr and Zisserman, CVIU 2000) is
/// strictly lower, or its inlier count strictly higher. The search stops after max_iterations or once
/// ln(1-p)/ln(1-P) hypotheses are done, P being the exact probability of an all-inlier sample without
/// replacement. Deviations from OpenCV, which the paper used: MSAC score by default, the best model is
/// refined on its inliers, and the mask belongs to the model that is returned: exactly the matches whose
/// error under it is <= threshold.
///
/// Presets: `h`, `f` choose the model. No model: all zero and too_few (fewer matches than a sample),
/// degenerate (no valid sample exists, or nothing but the sample itself agrees: the model is returned
/// unverified) or no_model. score = squared error in px^2, negated. O(iterations * N) time, O(N) memory.
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
