#pragma once

#include <string>

#include "corrsel/search/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// The other parts of the search are those of UsacOptions.
struct AcransacOptions : SearchOptions {
  AcransacOptions();

  ModelKind model = ModelKind::kHomography;  ///< kHomography, kFundamental or kEssential
  double widen = 2;                          ///< inlier threshold over the threshold of the significance
  double min_threshold =
      0;  ///< smallest inlier threshold, px; 0 = 5 (homography), 2 (fundamental) or 1.5 (essential matrix)
  double max_threshold = 10;  ///< largest inlier threshold, px
  void visit(OptionVisitor& visitor) const override;
  std::string missingInput(const Correspondences& matches) const { return missingFor(matches, model); }
};

/// AC-RANSAC: a contrario random sample consensus, which finds its threshold by itself.
///
/// Idea: an inlier threshold is a guess about the noise. The number of false alarms needs no guess: it tells
/// for every threshold how many models would gather so many matches within it by chance. The threshold with
/// the smallest number is the one that separates the model from chance best. The number also decides
/// whether there is a model at all.
///
/// Algorithm: search/significant_model.h finds the model and the threshold e at which it is the most
/// significant. The test is the one that defines the confidence of all selectors (search/significance.h).
/// e is about 1.5 to 2 standard deviations of the noise, so that it leaves out inliers. Selected is
/// therefore every match whose error is at most `widen` e, but at least `min_threshold` and at most
/// `max_threshold`.
///
/// Input: coordinates. With `sampler` = `prosac` also the column `distance` (and `second_distance`) or
/// `probability`; without them samples are uniform, and the message reports this. With `sampler` = `frames`
/// also the local affine frames. The sizes of the images are used where they are known.
///
/// Presets: `h`, `f` and `e` choose the model.
///
/// Failure: `uncertain` where chance explains the best model (`min_confidence`), `no_model` where it agrees
/// with nothing but its sample, `too_few` (fewer matches than a sample), `degenerate` (no valid sample), and
/// `time_limit` with the best model so far. The message names the threshold. The score is the squared error
/// in px^2, negated; iterations are hypotheses.
///
/// Cost: that of UsacSelector and 2 to 5 tests of significance, O(N log N).
///
/// Source: Moisan and Stival, IJCV 2004 (fundamental matrix); Moisan, Moulon and Monasse, IPOL 2012
/// (homography). Deviations: every image point counts once, errors of the smaller direction and a background
/// that is not uniform; the number of tests is that of the hypotheses that were drawn, not of all samples;
/// MSAC at 5 px with the parts of USAC searches, and the significance tests only what it finds.
class AcransacSelector : public SelectorWithOptions<AcransacOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "acransac"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override {
    return options_.missingInput(matches);
  }
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
