#include "auto/parallax.h"

#include <algorithm>
#include <cmath>

#include "corrsel/random.h"
#include "geometry/homography.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/fundamental_model.h"
#include "search/local_optimization.h"
#include "search/verifier.h"

namespace corrsel::core {
namespace {

constexpr double kOffPlane = 15;  // px
constexpr std::size_t kMinGood = 100, kGoodShare = 8;
constexpr int kPairs = 300;
constexpr double kTimesChance = 40, kShareOfPlane = 0.5, kOutnumbers = 1.25, kMinTimesChance = 8;

}  // namespace

bool ParallaxTest::find(const Correspondences& pixels, const NormalizedMatches& matches,
                        const std::vector<std::uint32_t>& best_first, const cv::Matx33d& plane,
                        const std::vector<double>& errors, double area, const Thresholds& thresholds,
                        std::uint64_t seed, cv::Matx33d& fundamental) {
  const std::size_t n = matches.size();
  const std::size_t good = std::min(n, std::max(kMinGood, n / kGoodShare));
  off_plane_.clear();
  for (std::size_t rank = 0; rank < good; ++rank)
    if (errors[best_first[rank]] > kOffPlane * kOffPlane) off_plane_.push_back(best_first[rank]);
  if (off_plane_.size() < 2) return false;
  const Verifier verifier(matches, Residual::kSampson, thresholds.fundamental * matches.scale, true);
  Random random(seed);
  Candidate best;
  if (!improveByParallax(verifier, plane, off_plane_, kPairs, random, best)) return false;
  optimizeLocally(FundamentalModel(), verifier, best);
  errors_.resize(n);
  modelErrors(Residual::kSampson, best.model, matches, 0, n, errors_.data());
  std::size_t off = 0;
  for (std::vector<std::uint8_t>* const mask : {&off_agreeing_, &on_, &on_agreeing_}) {
    // Not assign(), of which GCC 14 assumes that it gets a size beyond all memory, and warns.
    mask->resize(n);
    std::fill(mask->begin(), mask->end(), std::uint8_t{0});
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t agrees = errors_[i] <= verifier.squaredThreshold() ? 1 : 0;
    if (errors[i] > kOffPlane * kOffPlane) {
      ++off;
      off_agreeing_[i] = agrees;
    } else if (errors[i] <= thresholds.homography * thresholds.homography) {
      on_[i] = 1;
      on_agreeing_[i] = agrees;
    }
  }
  const double chance = 2 * std::sqrt(2.0) * thresholds.fundamental / std::sqrt(area);
  const auto off_agreeing = static_cast<double>(cells_.count(pixels, off_agreeing_));
  const auto on = static_cast<double>(cells_.count(pixels, on_));
  if (2 * static_cast<double>(cells_.count(pixels, on_agreeing_)) < on) return false;
  const cv::Matx33d candidate = matches.fundamentalToPixels(best.model);
  const bool clear =
      off_agreeing >= kTimesChance * chance * static_cast<double>(off) && off_agreeing >= kShareOfPlane * on;
  if (!clear) {
    if (off_agreeing < kOutnumbers * on ||
        off_agreeing < kMinTimesChance * chance * static_cast<double>(off)) {
      return false;
    }
    far_.clear();
    for (std::uint32_t i = 0; i < n; ++i)
      if (errors[i] > kOffPlane * kOffPlane) far_.push_back(i);
    significance_.assign(pixels.subset(far_));
    if (significance_.fundamental(candidate, kPairs).confidence < kSignificantConfidence) return false;
  }
  fundamental = candidate;
  return true;
}

}  // namespace corrsel::core
