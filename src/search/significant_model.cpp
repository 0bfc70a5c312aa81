#include "search/significant_model.h"

#include "search/local_optimization.h"

namespace corrsel::core {
namespace {

constexpr double kSearchThreshold = 5;  // px
constexpr double kRefitWidth = 2;       // times the threshold at which the model is the most significant
constexpr int kMaxRefits = 3;

}  // namespace

SignificantModel searchSignificantModel(const NormalizedMatches& matches, SignificanceTest& test,
                                        const SearchParts& parts, SearchParameters parameters,
                                        const std::vector<std::uint32_t>* best_first,
                                        const Deadline& deadline, Workspace& workspace) {
  const Model& model = parts.model;
  parameters.threshold = kSearchThreshold;
  SignificantModel found;
  found.outcome = search(matches, parts, parameters, best_first, deadline, workspace);
  Candidate& best = found.outcome.best;
  if (!best.exists()) return found;
  const auto hypotheses = static_cast<std::uint64_t>(found.outcome.iterations);
  found.model = model.toPixels(matches, best.model);
  found.significance = model.significance(test, found.model, hypotheses);
  double threshold = 0;  // of the significance before
  for (int refit = 0; refit < kMaxRefits && found.significance.threshold != threshold; ++refit) {
    threshold = found.significance.threshold;
    const Verifier verifier(matches, model.traits.residual, kRefitWidth * threshold * matches.scale, true);
    Candidate refitted;
    if (!verifier.improve(best.model, refitted)) break;
    optimizeLocally(model, verifier, refitted);
    const cv::Matx33d pixels = model.toPixels(matches, refitted.model);
    const Significance significance = model.significance(test, pixels, hypotheses);
    if (significance.confidence <= found.significance.confidence) break;
    best = refitted;
    found.model = pixels;
    found.significance = significance;
  }
  return found;
}

}  // namespace corrsel::core
