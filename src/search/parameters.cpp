#include "search/parameters.h"

namespace corrsel::core {

SearchParameters parametersOf(const ConsensusOptions& options) {
  SearchParameters parameters;
  parameters.threshold = options.threshold;
  parameters.max_iterations = options.max_iterations;
  parameters.confidence = options.confidence;
  parameters.msac = options.score == ConsensusOptions::Score::kMsac;
  parameters.one_to_one = options.one_to_one;
  parameters.sprt = options.sprt;
  parameters.sprt_inlier_ratio = options.sprt_inlier_ratio;
  parameters.escape_degeneracy = options.degensac;
  parameters.local_optimization = options.local_optimization;
  parameters.refine = options.refine;
  parameters.seed = static_cast<std::uint64_t>(options.seed);
  return parameters;
}

}  // namespace corrsel::core
