#include "auto/gathering.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "auto/fundamental_search.h"
#include "auto/homography_search.h"
#include "base/gather.h"
#include "geometry/essential.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr double kLooseShare = 0.07;        // of the matches off the homography: a loose leftover
constexpr double kPoseConfidence = 0.9999;  // of having drawn an all-inlier sample
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
  homography_inliers.assign(size(), 0);
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

void Gathering::findPose() {
  if (evidence_.pose_known || !isCalibrated()) return;
  evidence_.pose_known = true;
  if (effort_.timed_out) return;
  PoseParameters parameters;
  parameters.search.threshold = parameters.threshold;
  parameters.search.seed = static_cast<std::uint64_t>(options_.seed);
  parameters.search.confidence = kPoseConfidence;
  parameters.supported = &memory_.support.extended();
  parameters.guess = memory_.matches.guess;
  Selection remarks;
  evidence_.pose =
      memory_.pose_search.find(memory_.matches, parameters, effort_.deadline, effort_.workspace, remarks);
  evidence_.guess = remarks.guess;
  effort_.hypotheses += static_cast<std::uint64_t>(remarks.iterations);
  effort_.timed_out = effort_.timed_out || remarks.status == Status::kTimeLimit;
}

void Gathering::addParallax() {
  if (effort_.timed_out) {
    evidence_.parallax = false;
    return;
  }
  if (isCalibrated()) {
    findPose();
    evidence_.parallax = evidence_.pose && evidence_.pose->motion == Motion::kGeneral;
    return;
  }
  const PlaneOfMatches plane = {
      memory_.matches,        memory_.normalized,        memory_.best_first,           memory_.ranked,
      normalized_homography_, memory_.homography_errors, memory_.thresholds.homography};
  evidence_.parallax =
      memory_.parallax.find(plane, memory_.support.area(), memory_.thresholds.fundamental,
                            static_cast<std::uint64_t>(options_.seed), parallax_fundamental_);
}

/// The essential matrix of the pose, if the camera moved.
FundamentalEvidence Gathering::essential() {
  FundamentalEvidence result;
  result.kind = ModelKind::kEssential;
  findPose();
  result.found = evidence_.pose &&
                 (evidence_.pose->motion == Motion::kGeneral || evidence_.pose->motion == Motion::kPlanar);
  if (!result.found) return result;
  result.model = essentialOf(evidence_.pose->pose);
  result.confidence = memory_.significance.essential(result.model, effort_.hypotheses).confidence;
  return result;
}

FundamentalEvidence Gathering::fundamental() {
  FundamentalSearch search(options_, memory_, effort_,
                           evidence_.homography.found ? &normalized_homography_ : nullptr);
  search.run(evidence_.parallax.value_or(false) ? &parallax_fundamental_ : nullptr);
  return search.best();
}

void Gathering::addFundamental() {
  FundamentalEvidence& found = evidence_.fundamental.emplace(isCalibrated() ? essential() : fundamental());
  if (!found.found) return;
  std::vector<double>& errors = memory_.fundamental_errors;
  selectionErrors(found.kind, found.model, memory_.matches, memory_.rays, errors);
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
