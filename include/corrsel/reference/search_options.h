#pragma once

#include "corrsel/confidence.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Options of the searches that are there for comparison with `ransac` and `usac`.
struct ReferenceSearchOptions : ConfidenceOptions {
  ModelKind model = ModelKind::kHomography;  ///< kHomography or kFundamental
  double threshold = 0;                      ///< inlier threshold, px; 0 = what the selector's header gives
  int max_iterations = 0;                    ///< hypotheses at most; 0 = what the selector's header gives
  int seed = 0;                              ///< of the samples
  double max_seconds = 0;                    ///< time limit, s; 0 = none
  void visit(OptionVisitor& visitor) const override;
};

}  // namespace corrsel::core
