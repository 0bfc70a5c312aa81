#include "search/local_optimization.h"

namespace corrsel::core {
namespace {

constexpr int kMaxSteps = 6;
constexpr double kWorthwhile = 1e-3;  // relative drop of the cost that justifies another step

/// Takes steps at the threshold as long as they lower the cost.
void descend(const Model& kind, const Verifier& verifier, Candidate& best) {
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto before = static_cast<double>(best.cost);
    cv::Matx33d model = best.model;
    if (!kind.refine(verifier.matches(), verifier.squaredThreshold(), model)) return;
    if (!verifier.improve(model, best) || static_cast<double>(best.cost) > (1 - kWorthwhile) * before) return;
  }
}

}  // namespace

void optimizeLocally(const Model& kind, const Verifier& verifier, Candidate& best) {
  cv::Matx33d model = best.model;
  if (kind.traits.refines_fully) {
    if (kind.refine(verifier.matches(), verifier.squaredThreshold(), model)) verifier.improve(model, best);
    return;
  }
  for (const float width : {4.0F, 2.0F}) {
    if (!kind.refine(verifier.matches(), width * verifier.squaredThreshold(), model)) break;
  }
  verifier.improve(model, best);
  descend(kind, verifier, best);
}

}  // namespace corrsel::core
