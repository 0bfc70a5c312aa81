#include "search/local_optimization.h"

namespace corrsel::core {
namespace {

constexpr int kMostSteps = 6;
constexpr double kWorthwhile = 1e-3;  // relative drop of the cost that justifies another step

/// Takes steps at the threshold as long as they lower the cost.
void descend(const TwoViewProblem& problem, const Verifier& verifier, Candidate& best) {
  for (int step = 0; step < kMostSteps; ++step) {
    const auto before = static_cast<double>(best.cost);
    cv::Matx33d model = best.model;
    if (!problem.refine(verifier.matches(), verifier.residual(), verifier.squaredThreshold(), model)) return;
    if (!verifier.improve(model, best) || static_cast<double>(best.cost) > (1 - kWorthwhile) * before) return;
  }
}

}  // namespace

void optimizeLocally(const TwoViewProblem& problem, const Verifier& verifier, Candidate& best) {
  cv::Matx33d model = best.model;
  for (const float width : {4.0F, 2.0F}) {
    if (!problem.refine(verifier.matches(), verifier.residual(), width * verifier.squaredThreshold(), model))
      break;
  }
  verifier.improve(model, best);
  descend(problem, verifier, best);
}

}  // namespace corrsel::core
