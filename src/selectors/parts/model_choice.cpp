#include "selectors/parts/model_choice.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "auto/leftover.h"
#include "auto/local_support.h"
#include "auto/parallax.h"
#include "base/deadline.h"
#include "base/workspace_scope.h"
#include "geometry/normalization.h"
#include "geometry/residual.h"
#include "search/ordering.h"
#include "search/search.h"
#include "search/significance.h"
#include "search/two_view.h"

namespace corrsel::core {
namespace {

constexpr double kParallax = 1.5;  // px: largest error of a match that shows parallax
constexpr double kOutside = 10;    // px: what is farther away is not explained by a homography

/// The options with a model of their own.
struct Settings : ConsensusOptions {
  explicit Settings(const ConsensusOptions& options) : ConsensusOptions(options) {}
  void visit(OptionVisitor&) const override {}
};

/// Memory that is kept between calls.
struct ChoiceMemory {
  Ordering ordering;
  std::vector<std::uint32_t> rows, identity, best_first;
  NormalizedMatches normalized;
  LocalSupport support;
  Leftover leftover;
  ParallaxTest parallax;
  SignificanceTest significance;
  std::vector<double> errors;
  std::vector<std::uint8_t> explained;
};

/// Returns whether the homography leaves more over than noise and repeated structure do.
bool leavesDepthOver(const Correspondences& matches, const ConsensusOptions& options,
                     double homography_threshold, double fundamental_threshold, const cv::Matx33d& homography,
                     ChoiceMemory& work) {
  const std::size_t n = matches.size();
  const auto seed = static_cast<std::uint64_t>(options.seed);
  work.ordering.shuffle(matches, seed, work.rows);
  const Correspondences shuffled = matches.subset(work.rows);
  work.identity.resize(n);
  std::iota(work.identity.begin(), work.identity.end(), 0U);
  if (!work.ordering.byQuality(shuffled, work.identity, work.best_first)) work.best_first = work.identity;
  work.support.compute(shuffled, work.best_first);
  work.leftover.assign(shuffled);
  work.errors.resize(n);
  pixelErrors(Residual::kSmallerTransfer, homography, shuffled, work.errors.data());
  const double outside = std::max(homography_threshold, std::min(2 * homography_threshold, kOutside));
  std::size_t explained = 0;
  work.explained.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    work.explained[i] = work.errors[i] <= outside * outside ? 1 : 0;
    explained += work.explained[i];
  }
  if (work.leftover.isSizable(work.leftover.coherent(work.support.local(), work.explained), explained))
    return true;
  normalizeMatches(shuffled, work.identity, work.normalized);
  cv::Matx33d fundamental;
  return work.parallax.find(shuffled, work.normalized, work.best_first,
                            work.normalized.homographyFromPixels(homography), work.errors,
                            work.support.area(), {outside / 2, std::min(fundamental_threshold, kParallax)},
                            seed, fundamental);
}

}  // namespace

void searchEitherModel(const Correspondences& matches, const ConsensusOptions& options,
                       double homography_threshold, double fundamental_threshold, Selection& result) {
  const Deadline deadline(options.max_seconds);
  ChoiceMemory& work = WorkspaceScope::part<ChoiceMemory>();
  Settings settings(options);
  settings.model = ModelKind::kHomography;
  searchConsensus(matches, settings, homography_threshold, result);
  const bool has_plane = result.model_kind == ModelKind::kHomography && result.status != Status::kDegenerate;
  work.significance.assign(matches);
  double plane_confidence = 0;
  if (has_plane) {
    plane_confidence =
        work.significance.homography(result.model, static_cast<std::uint64_t>(result.iterations)).confidence;
    if (plane_confidence >= kBelievedConfidence &&
        !leavesDepthOver(matches, options, homography_threshold, fundamental_threshold, result.model, work))
      return;
  }
  if (deadline.passed()) return;
  if (options.max_seconds > 0) settings.max_seconds = options.max_seconds - deadline.elapsed();
  settings.model = ModelKind::kFundamental;
  if (settings.sampler == ConsensusOptions::Sampler::kFrames)
    settings.sampler = ConsensusOptions::Sampler::kProsac;
  Selection space;
  space.mask.assign(matches.size(), 0);
  searchConsensus(matches, settings, fundamental_threshold, space);
  const int iterations = result.iterations + space.iterations;
  if (space.model_kind == ModelKind::kFundamental && space.status != Status::kDegenerate) {
    const double confidence =
        work.significance.fundamental(space.model, static_cast<std::uint64_t>(space.iterations)).confidence;
    if (confidence >= kBelievedConfidence || !has_plane || confidence > plane_confidence) result = space;
  }
  result.iterations = iterations;
}

}  // namespace corrsel::core
