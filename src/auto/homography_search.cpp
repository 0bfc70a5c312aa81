#include "auto/homography_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/residual.h"
#include "search/homography_model.h"
#include "search/local_optimization.h"
#include "search/prosac_proposal.h"

namespace corrsel::core {
namespace {

// A half or a quarter of the budgets (seeds, best supported matches, hypotheses) changes the mean F by less
// than 1 on VGG, SymBench, KITTI and AdelaideRMF.
constexpr float kMinSeedSupport = 1;    // S of a seed
constexpr int kMaxSeeds = 60;           // that are grown
constexpr int kMaxFruitlessSeeds = 3;   // in a row, after which a model with many inliers is kept
constexpr double kWorthRefining = 0.7;  // gain of a candidate at the wide threshold, relative to the best
constexpr std::size_t kBestSupported = 200;  // matches that join the first search
constexpr int kFirstHypotheses = 2000, kSecondHypotheses = 2000;
constexpr std::size_t kManyInliers = 40;  // which make the second search unnecessary, with
constexpr double kShareOfLocal = 0.6;     // this share of the local set
constexpr double kExplained = 0.9;        // share of the local set that makes all further search unnecessary

}  // namespace

int hypothesesOf(const AutoOptions& options, int hypotheses) {
  constexpr int kFast = 4;
  return options.hard_search > 0 ? hypotheses : hypotheses / kFast;
}

int hardHypotheses(int option, std::size_t matches, double max_factor) {
  constexpr double kMatches = 1500;
  return static_cast<int>(option * std::clamp(kMatches / static_cast<double>(matches), 1.0, max_factor));
}

HomographySearch::HomographySearch(const AutoOptions& options, AutoMemory& memory, Effort& effort)
    : options_(options),
      memory_(memory),
      effort_(effort),
      wide_(memory.normalized, Residual::kSymmetricTransfer,
            2 * memory.thresholds.homography * memory.normalized.scale, true, &memory.distinct),
      narrow_(memory.normalized, Residual::kSymmetricTransfer,
              std::sqrt(2.0) * memory.thresholds.homography * memory.normalized.scale, true,
              &memory.distinct) {}

void HomographySearch::run() {
  memory_.homography_errors.resize(memory_.size());
  growSeeds();
  if (best_.exists() && explainsLocalSet()) {
    evaluate();
    if (isSignificant(confidence_)) return;
  }
  gatherSupported();
  search(memory_.searched, hypothesesOf(options_, kFirstHypotheses));
  const auto local = static_cast<double>(memory_.support.localSize());
  const bool enough =
      best_.distinct >= kManyInliers && static_cast<double>(best_.distinct) >= kShareOfLocal * local;
  if (enough || effort_.timed_out) {
    evaluate();
    if (isSignificant(confidence_) || effort_.timed_out) return;
  }
  searchFrames();
  search(memory_.by_support, hypothesesOf(options_, kSecondHypotheses));
  evaluate();
  if (isSignificant(confidence_) || options_.hard_search == 0 || effort_.timed_out) return;
  search(memory_.best_first, hardHypotheses(options_.hard_search, memory_.size(), 10));
  evaluate();
}

void HomographySearch::growSeeds() {
  const LocalSupport& support = memory_.support;
  memory_.seeds.clear();
  for (const std::uint32_t seed : memory_.by_support) {
    if (support.support()[seed] < kMinSeedSupport) break;
    memory_.seeds.push_back(seed);
  }
  SeedGrowing& growing = memory_.growing;
  growing.start(memory_.matches, support.weights(), support.diagonal(), memory_.seeds, support.maps());
  int grown = 0, last_better = 0;
  while (grown < hypothesesOf(options_, kMaxSeeds) && growing.next()) {
    ++grown;
    if (growing.map() == nullptr) continue;
    if (best_.inliers >= kManyInliers && grown - last_better > kMaxFruitlessSeeds) break;
    const std::int64_t before = best_.cost;
    consider(memory_.normalized.homographyFromPixels(*growing.map()));
    if (best_.cost < before) {
      last_better = grown;
      if (explainsLocalSet()) break;
    }
    effort_.timed_out = effort_.deadline.passed();
    if (effort_.timed_out) break;
  }
  effort_.hypotheses += static_cast<std::uint64_t>(grown);
}

/// Writes the local set, the survivors and the best supported matches, in the order of support.
void HomographySearch::gatherSupported() {
  const LocalSupport& support = memory_.support;
  memory_.taken = support.local();
  for (const std::uint32_t i : support.survivors()) memory_.taken[i] = 1;
  for (std::size_t i = 0; i < std::min(kBestSupported, memory_.size()); ++i) {
    const std::uint32_t row = memory_.by_support[i];
    if (support.support()[row] > 0) memory_.taken[row] = 1;
  }
  memory_.searched.clear();
  for (const std::uint32_t i : memory_.by_support)
    if (memory_.taken[i] != 0) memory_.searched.push_back(i);
}

/// Searches by PROSAC in the given order.
void HomographySearch::search(const AutoMemory::Rows& order, int hypotheses) {
  const HomographyModel model;
  if (effort_.timed_out || order.size() < static_cast<std::size_t>(model.traits.sample_size)) return;
  SearchParameters parameters;
  parameters.threshold = memory_.thresholds.homography;
  parameters.max_iterations = hypotheses;
  parameters.seed = static_cast<std::uint64_t>(options_.seed);
  addBest(core::search(memory_.normalized, {model, effort_.workspace.part<ProsacProposal>()}, parameters,
                       &order, effort_.deadline, effort_.workspace));
}

/// Searches among the maps that the frames of single matches give, where there are frames.
void HomographySearch::searchFrames() {
  const Correspondences& matches = memory_.matches;
  if (options_.hard_search == 0 || effort_.timed_out || matches.left_frame.empty() ||
      matches.right_frame.empty())
    return;
  SearchParameters parameters;
  parameters.threshold = memory_.thresholds.homography;
  memory_.frames.read(matches, memory_.identity, &memory_.by_support);
  addBest(core::search(memory_.normalized, {HomographyModel(), memory_.frames}, parameters, nullptr,
                       effort_.deadline, effort_.workspace));
}

void HomographySearch::addBest(const SearchOutcome& outcome) {
  effort_.add(outcome);
  if (outcome.best.exists()) consider(outcome.best.model);
}

/// Refines a homography on all matches and keeps it if it is the best one so far.
void HomographySearch::consider(const cv::Matx33d& normalized) {
  const HomographyModel model(Residual::kSymmetricTransfer);
  Candidate candidate;
  if (!wide_.improve(normalized, candidate)) return;
  optimizeLocally(model, wide_, candidate);
  const std::int64_t gain =
      static_cast<std::int64_t>(memory_.size()) * ScoreRule::kOutlierCost - candidate.cost;
  if (static_cast<double>(gain) < kWorthRefining * static_cast<double>(best_gain_)) return;
  best_gain_ = std::max(best_gain_, gain);
  Candidate refined;
  if (!narrow_.improve(candidate.model, refined)) return;
  optimizeLocally(model, narrow_, refined);
  if (refined.cost < best_.cost) best_ = refined;
}

/// Computes errors, inliers and confidence of the best homography.
void HomographySearch::evaluate() {
  std::vector<double>& errors = memory_.homography_errors;
  memory_.homography_inliers.assign(memory_.size(), 0);
  if (!best_.exists()) {
    std::fill(errors.begin(), errors.end(), std::numeric_limits<double>::infinity());
    return;
  }
  model_ = memory_.normalized.homographyToPixels(best_.model);
  pixelErrors(Residual::kSmallerTransfer, model_, memory_.matches, errors.data());
  selectWithin(errors, memory_.thresholds.homography, memory_.homography_inliers);
  confidence_ = memory_.significance.homography(model_, effort_.hypotheses).confidence;
}

/// Whether the best homography leaves next to nothing of the local set over.
bool HomographySearch::explainsLocalSet() const {
  std::vector<double>& errors = memory_.homography_errors;
  const cv::Matx33d model = memory_.normalized.homographyToPixels(best_.model);
  pixelErrors(Residual::kSmallerTransfer, model, memory_.matches, errors.data());
  const double squared =
      kNearHomography * kNearHomography * memory_.thresholds.homography * memory_.thresholds.homography;
  std::size_t explained = 0;
  for (std::size_t i = 0; i < errors.size(); ++i)
    explained += memory_.support.local()[i] != 0 && errors[i] <= squared ? 1 : 0;
  return explained >= kManyInliers &&
         static_cast<double>(explained) >= kExplained * static_cast<double>(memory_.support.localSize());
}

}  // namespace corrsel::core
