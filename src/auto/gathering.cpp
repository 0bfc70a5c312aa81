#include "auto/gathering.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "auto/homography_search.h"
#include "base/gather.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/fundamental_model.h"
#include "search/local_optimization.h"
#include "search/uniform_proposal.h"

namespace corrsel::core {
namespace {

constexpr int kFundamentalHypotheses = 300;
constexpr std::size_t kMinMatches = 12;  // that F is estimated from
constexpr double kExplained = 0.95;      // of the local set: no better fundamental matrix is searched
constexpr double kMinShareOfOffPlane =
    0.25;  // of the matches off a plane: as many agree with the scene rather than with repeated structure
constexpr double kLooseShare = 0.08;  // of the matches off the homography: a loose leftover
constexpr double kNearFundamental =
    3;  // times the threshold: a member of the local set is not left over by F

std::size_t count(const AutoMemory::Mask& mask) {
  return static_cast<std::size_t>(std::accumulate(mask.begin(), mask.end(), 0));
}

}  // namespace

void AutoMemory::assign(const Correspondences& input, const AutoOptions& options) {
  thresholds = Thresholds(options);
  ordering.shuffle(input, static_cast<std::uint64_t>(options.seed), rows);
  gather(input, rows, matches);
  identity.resize(size());
  std::iota(identity.begin(), identity.end(), 0U);
  normalizeMatches(matches, identity, normalized);
  ranked = ordering.byQuality(matches, identity, best_first);
  if (!ranked) best_first = identity;
  distinct.group(normalized, normalized.scale);
  significance.assign(matches);
  leftover.assign(matches);
}

void Gathering::start() {
  const bool complete = memory_.support.compute(memory_.matches, memory_.best_first, options_.threads,
                                                effort_.support_deadline);
  evidence_.local_support = !memory_.support.survivors().empty();
  sortBySupport();
  if (options_.model != AutoOptions::Model::kFundamental) findHomography();
  effort_.timed_out |= !complete;
}

void Gathering::gather(Need need) {
  switch (need) {
    case Need::kNone:
      return;
    case Need::kHomographyLeftover:
      return addHomographyLeftover();
    case Need::kParallax:
      return addParallax();
    case Need::kFundamental:
      return addFundamental();
    case Need::kFundamentalLeftover:
      return addFundamentalLeftover();
    case Need::kLocalConfidence:
      evidence_.local_confidence = memory_.significance.local(memory_.support.extended()).confidence;
  }
}

/// Writes all matches by falling support, then by quality.
void Gathering::sortBySupport() {
  const std::vector<float>& support = memory_.support.support();
  AutoMemory::Rows& rank = memory_.rank;
  rank.resize(memory_.size());
  for (std::uint32_t k = 0; k < rank.size(); ++k) rank[memory_.best_first[k]] = k;
  memory_.by_support = memory_.best_first;
  // A stable sort would allocate memory.
  std::sort(memory_.by_support.begin(), memory_.by_support.end(), [&](std::uint32_t a, std::uint32_t b) {
    return support[a] != support[b] ? support[a] > support[b] : rank[a] < rank[b];
  });
}

void Gathering::findHomography() {
  HomographySearch search(options_, memory_, effort_);
  search.run();
  if (!search.found()) return;
  memory_.thresholds.adaptHomography(memory_.homography_errors);
  selectWithin(memory_.homography_errors, memory_.thresholds.homography, memory_.homography_inliers);
  normalized_homography_ = search.normalizedModel();
  evidence_.homography.found = true;
  evidence_.homography.model = search.model();
  evidence_.homography.confidence = search.confidence();
  const Correspondences& m = memory_.matches;
  std::vector<float>& displacements = memory_.displacements;
  displacements.clear();
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (memory_.homography_inliers[i] == 0) continue;
    displacements.push_back(std::hypot(m.right_x[i] - m.left_x[i], m.right_y[i] - m.left_y[i]));
  }
  if (displacements.empty()) return;
  const auto middle = displacements.begin() + static_cast<std::ptrdiff_t>(displacements.size() / 2);
  std::nth_element(displacements.begin(), middle, displacements.end());
  evidence_.homography.displacement = *middle;
}

void Gathering::addHomographyLeftover() {
  const AutoMemory::Mask &local = memory_.support.local(), &inliers = memory_.homography_inliers;
  const std::vector<double>& errors = memory_.homography_errors;
  AutoMemory::Mask &near = memory_.near_homography, &loose = memory_.loose;
  near.resize(errors.size());
  loose.resize(errors.size());
  const double squared =
      kNearHomography * kNearHomography * memory_.thresholds.homography * memory_.thresholds.homography;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    near[i] = errors[i] <= squared ? 1 : 0;
    loose[i] = local[i] != 0 && inliers[i] == 0 ? 1 : 0;
  }
  Leftover& leftover = memory_.leftover;
  const std::size_t n_inliers = count(inliers), loose_places = leftover.distinctPlaces(loose);
  evidence_.homography_leftover = {
      leftover.isSizable(leftover.coherent(local, near), count(near)),
      leftover.isSizable(loose_places, n_inliers) &&
          static_cast<double>(loose_places) > kLooseShare * static_cast<double>(errors.size() - n_inliers)};
}

void Gathering::addParallax() {
  if (effort_.timed_out) {
    evidence_.parallax = false;
    return;
  }
  const PlaneOfMatches plane = {
      memory_.matches,        memory_.normalized,        memory_.best_first,           memory_.ranked,
      normalized_homography_, memory_.homography_errors, memory_.thresholds.homography};
  evidence_.parallax =
      memory_.parallax.find(plane, memory_.support.area(), memory_.thresholds.fundamental,
                            static_cast<std::uint64_t>(options_.seed), parallax_fundamental_);
}

/// Searches among some matches, and refines on all.
bool Gathering::searchFundamental(const AutoMemory::Rows& rows, int hypotheses, double confidence,
                                  cv::Matx33d& model) {
  if (rows.size() < kMinMatches || effort_.timed_out) return false;
  const FundamentalModel kind;
  SearchParameters parameters;
  parameters.threshold = memory_.thresholds.fundamental;
  parameters.max_iterations = hypotheses;
  parameters.confidence = confidence;
  parameters.seed = static_cast<std::uint64_t>(options_.seed);
  // Uniform samples: in the order of support, the best matches lie on one surface.
  const SearchParts parts = {kind, effort_.workspace.part<UniformProposal>()};
  const SearchOutcome outcome =
      search(memory_.normalized, parts, parameters, &rows, effort_.deadline, effort_.workspace);
  effort_.add(outcome);
  if (!outcome.best.exists()) return false;
  const Verifier verifier(memory_.normalized, Residual::kSampson,
                          memory_.thresholds.fundamental * memory_.normalized.scale, true);
  Candidate candidate;
  if (!verifier.improve(outcome.best.model, candidate)) return false;
  optimizeLocally(kind, verifier, candidate);
  model = memory_.normalized.fundamentalToPixels(candidate.model);
  return true;
}

/// Keeps a fundamental matrix if it is more significant than the one so far.
void Gathering::takeFundamental(const cv::Matx33d& model) {
  FundamentalEvidence& found = *evidence_.fundamental;
  const double confidence = memory_.significance.fundamental(model, effort_.hypotheses).confidence;
  if (found.found && confidence <= found.confidence) return;
  found.found = true;
  found.model = model;
  found.confidence = confidence;
}

/// Makes fundamental matrices from the homography and pairs of other matches. It need not be significant:
/// where depth jumps from point to point, it holds for a few matches that lie on a plane by chance.
bool Gathering::searchBesideHomography(cv::Matx33d& model) {
  constexpr int kPairs = 1000;
  if (!evidence_.homography.found) return false;
  memory_.rest.clear();
  for (std::uint32_t i = 0; i < memory_.size(); ++i)
    if (memory_.homography_inliers[i] == 0) memory_.rest.push_back(i);
  if (memory_.rest.size() < 2) return false;
  const Verifier verifier(memory_.normalized, Residual::kSampson,
                          memory_.thresholds.fundamental * memory_.normalized.scale, true);
  Random random(static_cast<std::uint64_t>(options_.seed));
  Candidate best;
  if (!improveByParallax(verifier, normalized_homography_, memory_.rest, kPairs, random, best)) return false;
  optimizeLocally(FundamentalModel(), verifier, best);
  effort_.hypotheses += kPairs;
  model = memory_.normalized.fundamentalToPixels(best.model);
  return true;
}

/// The share of the local set that agrees with a fundamental matrix.
double Gathering::shareOfLocal(const cv::Matx33d& model) {
  const AutoMemory::Mask& local = memory_.support.local();
  std::vector<double>& errors = memory_.fundamental_errors;
  errors.resize(memory_.size());
  pixelErrors(Residual::kSampson, model, memory_.matches, errors.data());
  const double squared = memory_.thresholds.fundamental * memory_.thresholds.fundamental;
  std::size_t agreeing = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) agreeing += local[i] != 0 && errors[i] <= squared ? 1 : 0;
  return static_cast<double>(agreeing) /
         static_cast<double>(std::max<std::size_t>(1, memory_.support.localSize()));
}

/// The share of the matches off the homography that agrees with a fundamental matrix.
double Gathering::shareOfOffPlane(const cv::Matx33d& model) {
  std::vector<double>& errors = memory_.fundamental_errors;
  errors.resize(memory_.size());
  pixelErrors(Residual::kSampson, model, memory_.matches, errors.data());
  const double squared = memory_.thresholds.fundamental * memory_.thresholds.fundamental;
  std::size_t agreeing = 0, off = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (memory_.homography_inliers[i] != 0) continue;
    ++off;
    agreeing += errors[i] <= squared ? 1 : 0;
  }
  return static_cast<double>(agreeing) / static_cast<double>(std::max<std::size_t>(1, off));
}

/// Collects fundamental matrices from the cheapest source to the dearest one, and keeps the most significant.
void Gathering::searchFundamental() {
  FundamentalEvidence& found = *evidence_.fundamental;
  cv::Matx33d model;
  if (evidence_.parallax.value_or(false)) takeFundamental(parallax_fundamental_);
  if (!found.found || !memory_.ranked || shareOfLocal(found.model) < kExplained) {
    memory_.searched.clear();
    for (std::uint32_t i = 0; i < memory_.size(); ++i)
      if (memory_.support.local()[i] != 0) memory_.searched.push_back(i);
    // All hypotheses are drawn: the first good model is often good in a part of the scene only.
    if (searchFundamental(memory_.searched, kFundamentalHypotheses, 1, model) &&
        (!found.found || !memory_.ranked || shareOfOffPlane(model) >= kMinShareOfOffPlane)) {
      takeFundamental(model);
    }
  }
  // Few matches have few neighbours, and where depth jumps, neighbours do not agree.
  if (isSignificant(found.confidence) && 2 * memory_.support.localSize() >= count(memory_.homography_inliers))
    return;
  if (searchBesideHomography(model)) takeFundamental(model);
  if (options_.hard_search == 0) return;
  // A search that finds a model ends early.
  constexpr double kEarly = 0.999, kMaxFactor = 30;
  if (searchFundamental(memory_.by_support, hardHypotheses(options_.hard_search, memory_.size(), kMaxFactor),
                        kEarly, model))
    takeFundamental(model);
}

void Gathering::addFundamental() {
  FundamentalEvidence& found = evidence_.fundamental.emplace();
  searchFundamental();
  if (!found.found) return;
  std::vector<double>& errors = memory_.fundamental_errors;
  errors.resize(memory_.size());
  pixelErrors(Residual::kSampson, found.model, memory_.matches, errors.data());
  memory_.thresholds.adaptFundamental(errors);
  if (!evidence_.homography_leftover) return;
  const double squared = memory_.thresholds.fundamental * memory_.thresholds.fundamental;
  std::size_t loose = 0, explained = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (memory_.loose[i] == 0) continue;
    ++loose;
    explained += errors[i] <= squared ? 1 : 0;
  }
  found.explains_loose = 2 * explained >= loose;
}

void Gathering::addFundamentalLeftover() {
  const AutoMemory::Mask& local = memory_.support.local();
  const std::vector<double>& errors = memory_.fundamental_errors;
  const double squared = memory_.thresholds.fundamental * memory_.thresholds.fundamental;
  AutoMemory::Mask& near = memory_.near_fundamental;
  near.resize(errors.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double limit = (local[i] != 0 ? kNearFundamental * kNearFundamental : 1) * squared;
    near[i] = errors[i] <= limit ? 1 : 0;
  }
  Leftover& leftover = memory_.leftover;
  evidence_.fundamental_leftover = leftover.isSizable(leftover.coherent(local, near), count(near));
}

}  // namespace corrsel::core
