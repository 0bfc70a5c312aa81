#pragma once

#include <cstdint>

#include "corrsel/search/options.h"

namespace corrsel::core {

/// Numbers and switches of a search. The defaults are the parts of USAC; the time limit is a Deadline.
struct SearchParameters {
  double threshold = 5;       ///< inlier threshold, px
  int max_iterations = 0;     ///< hypotheses; 0 = what suits the proposal
  double confidence = 0.999;  ///< probability of having drawn an all-inlier sample at which the search stops
  bool msac = true;           ///< truncated squared errors (MSAC), else the number of inliers
  bool one_to_one = true;     ///< every image point counts at most once, where the model maps points
  bool sprt = true;           ///< bad hypotheses are rejected early by a sequential probability ratio test
  double sprt_inlier_ratio = 0;  ///< smallest inlier ratio that the SPRT must not miss; 0 = by the iterations
  bool escape_degeneracy = true;   ///< improve models that come from degenerate samples
  bool local_optimization = true;  ///< refine every new best model, not only the last one
  bool refine = true;              ///< least squares on the inliers of the best model
  std::uint64_t seed = 0;
};

/// The parameters that the options of `ransac` and `usac` ask for. The option `threshold` is taken as it is.
SearchParameters parametersOf(const ConsensusOptions& options);

}  // namespace corrsel::core
