#include "search/significant_model.h"

#include "search/local_optimization.h"
#include "search/two_view.h"
#include "search/verifier.h"

namespace corrsel::core {
namespace {

constexpr double kSearchThreshold = 5;  // px
constexpr double kRefitWidth = 2;       // times the threshold at which the model is the most significant
constexpr int kMostRefits = 3;

}  // namespace

SignificantModel searchSignificantModel(const NormalizedMatches& matches, SignificanceTest& test,
                                        const ConsensusOptions& options,
                                        const std::vector<std::uint32_t>* best_first,
                                        const Deadline& deadline, FrameHypotheses* frames) {
  const TwoViewProblem problem = problemOf(options);
  SignificantModel found;
  found.outcome = searchModel(matches, options, kSearchThreshold, best_first, deadline, frames);
  Candidate& best = found.outcome.best;
  if (!best.exists()) return found;
  const auto hypotheses = static_cast<std::uint64_t>(found.outcome.iterations);
  const auto judge = [&](const cv::Matx33d& pixels) {
    return problem.kind == ModelKind::kHomography ? test.homography(pixels, hypotheses)
                                                  : test.fundamental(pixels, hypotheses);
  };
  found.model = (matches.*problem.toPixels)(best.model);
  found.significance = judge(found.model);
  double threshold = 0;  // of the significance before
  for (int refit = 0; refit < kMostRefits && found.significance.threshold != threshold; ++refit) {
    threshold = found.significance.threshold;
    const Verifier verifier(matches, problem.residual, kRefitWidth * threshold * matches.scale, true);
    Candidate refitted;
    if (!verifier.improve(best.model, refitted)) break;
    optimizeLocally(problem, verifier, refitted);
    const cv::Matx33d pixels = (matches.*problem.toPixels)(refitted.model);
    const Significance significance = judge(pixels);
    if (significance.confidence <= found.significance.confidence) break;
    best = refitted;
    found.model = pixels;
    found.significance = significance;
  }
  return found;
}

}  // namespace corrsel::core
