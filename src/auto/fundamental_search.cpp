#include "auto/fundamental_search.h"

#include <algorithm>

#include "auto/homography_search.h"
#include "corrsel/random.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/fundamental_model.h"
#include "search/local_optimization.h"
#include "search/uniform_proposal.h"

namespace corrsel::core {
namespace {

constexpr int kLocalHypotheses = 300, kPairs = 1000;
constexpr std::size_t kMinMatches = 12;       // of a search
constexpr double kExplained = 0.95;           // of the local set
constexpr double kMinShareOfOffPlane = 0.25;  // of the matches off the homography
constexpr double kMaxHardFactor = 30;         // of hardHypotheses()
// Of having found a model, where the search may end early.
constexpr double kConfidence = 0.999;

}  // namespace

void FundamentalSearch::run(const cv::Matx33d* of_parallax) {
  if (of_parallax != nullptr) take(*of_parallax);
  if (!best_.found || !memory_.ranked || agreeingShare(best_.model, memory_.support.local(), 1) < kExplained)
    searchLocalSet();
  const auto on_plane =
      std::count(memory_.homography_inliers.begin(), memory_.homography_inliers.end(), std::uint8_t{1});
  if (isSignificant(best_.confidence) &&
      2 * memory_.support.localSize() >= static_cast<std::size_t>(on_plane)) {
    return;
  }
  searchBesideHomography();
  searchAll();
}

void FundamentalSearch::searchLocalSet() {
  memory_.searched.clear();
  for (std::uint32_t i = 0; i < memory_.size(); ++i)
    if (memory_.support.local()[i] != 0) memory_.searched.push_back(i);
  cv::Matx33d model;
  // All hypotheses are drawn: the first good model is often good in a part of the scene only.
  if (!search(memory_.searched, kLocalHypotheses, 1, model)) return;
  if (!best_.found || !memory_.ranked ||
      agreeingShare(model, memory_.homography_inliers, 0) >= kMinShareOfOffPlane)
    take(model);
}

void FundamentalSearch::searchBesideHomography() {
  if (homography_ == nullptr) return;
  memory_.rest.clear();
  for (std::uint32_t i = 0; i < memory_.size(); ++i)
    if (memory_.homography_inliers[i] == 0) memory_.rest.push_back(i);
  if (memory_.rest.size() < 2) return;
  const Verifier verifier(memory_.normalized, Residual::kSampson,
                          memory_.thresholds.fundamental * memory_.normalized.scale, true);
  Random random(static_cast<std::uint64_t>(options_.seed));
  Candidate best;
  cv::Matx33d model;
  const int pairs = hypothesesOf(options_, kPairs);
  if (!improveByParallax(verifier, *homography_, memory_.rest, pairs, random, best)) return;
  effort_.hypotheses += static_cast<std::uint64_t>(pairs);
  if (refine(best.model, model)) take(model);
}

void FundamentalSearch::searchAll() {
  if (options_.hard_search == 0) return;
  cv::Matx33d model;
  const int hypotheses = hardHypotheses(options_.hard_search, memory_.size(), kMaxHardFactor);
  if (search(memory_.by_support, hypotheses, kConfidence, model)) take(model);
}

/// Searches among some matches, and refines on all.
bool FundamentalSearch::search(const AutoMemory::Rows& rows, int hypotheses, double confidence,
                               cv::Matx33d& model) {
  if (rows.size() < kMinMatches || effort_.timed_out) return false;
  SearchParameters parameters;
  parameters.threshold = memory_.thresholds.fundamental;
  parameters.max_iterations = hypotheses;
  parameters.confidence = confidence;
  parameters.seed = static_cast<std::uint64_t>(options_.seed);
  const FundamentalModel kind;
  const SearchParts parts = {kind, effort_.workspace.part<UniformProposal>()};
  const SearchOutcome outcome =
      core::search(memory_.normalized, parts, parameters, &rows, effort_.deadline, effort_.workspace);
  effort_.add(outcome);
  return outcome.best.exists() && refine(outcome.best.model, model);
}

/// @param model  receives the refined matrix, px
bool FundamentalSearch::refine(const cv::Matx33d& normalized, cv::Matx33d& model) {
  const Verifier verifier(memory_.normalized, Residual::kSampson,
                          memory_.thresholds.fundamental * memory_.normalized.scale, true);
  Candidate candidate;
  if (!verifier.improve(normalized, candidate)) return false;
  optimizeLocally(FundamentalModel(), verifier, candidate);
  model = memory_.normalized.fundamentalToPixels(candidate.model);
  return true;
}

/// Keeps a fundamental matrix if it is more significant than the best one so far.
void FundamentalSearch::take(const cv::Matx33d& model) {
  const double confidence = memory_.significance.fundamental(model, effort_.hypotheses).confidence;
  if (best_.found && confidence <= best_.confidence) return;
  best_.found = true;
  best_.model = model;
  best_.confidence = confidence;
}

/// The share of the matches with this value in the mask that agrees with a fundamental matrix.
double FundamentalSearch::agreeingShare(const cv::Matx33d& model, const AutoMemory::Mask& mask,
                                        std::uint8_t value) {
  std::vector<double>& errors = memory_.fundamental_errors;
  errors.resize(memory_.size());
  pixelErrors(Residual::kSampson, model, memory_.matches, errors.data());
  const double squared = memory_.thresholds.fundamental * memory_.thresholds.fundamental;
  std::size_t agreeing = 0, all = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != value) continue;
    ++all;
    agreeing += errors[i] <= squared ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(agreeing) / static_cast<double>(all) : 0;
}

}  // namespace corrsel::core
