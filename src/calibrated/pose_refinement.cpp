#include "calibrated/pose_refinement.h"

#include <cmath>

#include "geometry/essential.h"

namespace corrsel::core {
namespace {

constexpr int kRounds = 5, kSteps = 10;
constexpr double kWidth = 2.5;        // of the threshold
constexpr double kMinAgreeing = 0.9;  // of those before
constexpr std::size_t kMinMatches = 6;

}  // namespace

/// Computes errors and the rows within the threshold and within the width of the fit.
void PoseRefinement::measure(const Pose& pose, const RayMatches& matches, double threshold,
                             const std::vector<std::uint8_t>* candidates) {
  errors_.resize(matches.size());
  squaredTangentSampson(essentialOf(pose), matches, errors_.data());
  agreeing_.clear();
  near_.clear();
  n_candidates_ = 0;
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    if (candidates != nullptr && (*candidates)[i] == 0) continue;
    ++n_candidates_;
    if (!(errors_[i] <= kWidth * kWidth * threshold * threshold)) continue;
    if (!isInFront(pose, matches, i, threshold)) continue;
    near_.push_back(i);
    if (errors_[i] <= threshold * threshold) agreeing_.push_back(i);
  }
}

void PoseRefinement::gather(const Pose& pose, const RayMatches& matches, bool robust) {
  rows_.clear();
  for (const std::uint32_t i : near_)
    if (!robust || chance_.counts(pose, matches, i)) rows_.push_back(i);
  gatherRays(matches, rows_, fitted_);
}

bool PoseRefinement::refine(const RayMatches& matches, const RayColumns& columns, double threshold,
                            bool robust, const std::vector<std::uint8_t>* candidates,
                            const PoseFreedom& freedom, Pose& pose) {
  measure(pose, matches, threshold, candidates);
  std::vector<std::uint32_t> before;
  for (int round = 0; round < kRounds; ++round) {
    const bool leaves_out = robust && round > 0;
    if (leaves_out && round == 1) {
      chance_.measure(pose, matches, columns, agreeing_, n_candidates_ - agreeing_.size(), threshold);
    }
    gather(pose, matches, leaves_out);
    if (rows_.size() < kMinMatches) return round > 0;
    if (round > 1 && rows_ == before) break;
    before = rows_;
    const std::size_t agreed = agreeing_.size();
    Pose fitted = pose;
    if (freedom.size > 0 && std::isnan(fitPose(fitted_, threshold, kSteps, fitted, freedom))) return false;
    measure(fitted, matches, threshold, candidates);
    if (static_cast<double>(agreeing_.size()) < kMinAgreeing * static_cast<double>(agreed)) {
      measure(pose, matches, threshold, candidates);
      break;
    }
    pose = fitted;
  }
  return true;
}

}  // namespace corrsel::core
