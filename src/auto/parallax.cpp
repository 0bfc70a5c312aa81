#include "auto/parallax.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/gather.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/fundamental_model.h"
#include "search/local_optimization.h"

namespace corrsel::core {
namespace {

constexpr int kPairs = 300;
// Near the plane.
constexpr std::size_t kMinBand = 6;
constexpr double kDirectionWidth = 2.0 / 3;  // of the threshold of the fundamental matrix
constexpr double kTests = 24e4;              // as SignificanceTest::fundamental() counts them at least
constexpr double kCoherent = 0.3, kMostOfBand = 0.75, kMinShareOfPlane = 0.01;
// Far from the plane.
constexpr double kOffPlane = 3;  // times the threshold of the plane
constexpr std::size_t kMinGood = 100, kGoodShare = 8;
constexpr double kShareOfPlane = 0.5, kShareOfOff = 0.1, kOutnumbers = 1.25, kMinTimesChance = 8;

double squaredFar(const PlaneOfMatches& plane) {
  return kOffPlane * kOffPlane * plane.threshold * plane.threshold;
}

}  // namespace

bool ParallaxTest::find(const PlaneOfMatches& plane, double area, double threshold, std::uint64_t seed,
                        cv::Matx33d& fundamental) {
  const Verifier verifier(plane.matches, Residual::kSampson, threshold * plane.matches.scale, true);
  const double chance = 2 * std::sqrt(2.0) * threshold / std::sqrt(area);
  return findNear(plane, verifier, threshold, Random(seed), fundamental) ||
         findFar(plane, verifier, kMinTimesChance * chance, Random(seed), fundamental);
}

/// Counts the matches on the plane and those far off it.
ParallaxTest::Counts ParallaxTest::count(const PlaneOfMatches& plane, const Verifier& verifier,
                                         const cv::Matx33d& fundamental) {
  const std::size_t n = plane.matches.size();
  errors_.resize(n);
  modelErrors(Residual::kSampson, fundamental, plane.matches, 0, n, errors_.data());
  for (std::vector<std::uint8_t>* const mask : {&off_agreeing_, &on_, &on_agreeing_}) {
    // Not assign(), of which GCC 14 assumes that it gets a size beyond all memory, and warns.
    mask->resize(n);
    std::fill(mask->begin(), mask->end(), std::uint8_t{0});
  }
  Counts counts;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t agrees = errors_[i] <= verifier.squaredThreshold() ? 1 : 0;
    if (plane.errors[i] > squaredFar(plane)) {
      counts.off += 1;
      off_agreeing_[i] = agrees;
    } else if (plane.errors[i] <= plane.threshold * plane.threshold) {
      on_[i] = 1;
      on_agreeing_[i] = agrees;
    }
  }
  counts.agreeing_off = static_cast<double>(cells_.count(plane.pixels, off_agreeing_));
  counts.on = static_cast<double>(cells_.count(plane.pixels, on_));
  counts.agreeing_on = static_cast<double>(cells_.count(plane.pixels, on_agreeing_));
  return counts;
}

bool ParallaxTest::findNear(const PlaneOfMatches& plane, const Verifier& verifier, double threshold,
                            Random random, cv::Matx33d& fundamental) {
  band_.gather(plane);
  const std::vector<std::uint32_t>& members = band_.members();
  if (members.size() < kMinBand) return false;
  // Pairs are drawn from the band alone, and scored by it.
  const NormalizedMatches& m = plane.matches;
  gather(m.left_x, members, band_matches_.left_x);
  gather(m.left_y, members, band_matches_.left_y);
  gather(m.right_x, members, band_matches_.right_x);
  gather(m.right_y, members, band_matches_.right_y);
  positions_.resize(members.size());
  std::iota(positions_.begin(), positions_.end(), 0U);
  const Verifier of_band(band_matches_, Residual::kSampson, threshold * m.scale, true);
  Candidate in_band, best;
  if (!improveByParallax(of_band, plane.homography, positions_, kPairs, random, in_band)) return false;
  if (!verifier.improve(in_band.model, best)) return false;
  optimizeLocally(FundamentalModel(), verifier, best);
  const PlaneBand::Direction found = band_.direction(best.model, kDirectionWidth * threshold);
  if (!isSignificant((found.log_ratio - std::log(kTests)) / std::log(10.0))) return false;
  if (found.share < kMostOfBand && band_.coherence() < kCoherent) return false;
  const Counts counts = count(plane, verifier, best.model);
  if (found.share * static_cast<double>(members.size()) < kMinShareOfPlane * counts.on) return false;
  fundamental = m.fundamentalToPixels(best.model);
  return 2 * counts.agreeing_on >= counts.on;
}

bool ParallaxTest::findFar(const PlaneOfMatches& plane, const Verifier& verifier, double min_agreeing_share,
                           Random random, cv::Matx33d& fundamental) {
  const std::size_t n = plane.matches.size();
  const std::size_t good = std::min(n, std::max(kMinGood, n / kGoodShare));
  off_plane_.clear();
  for (std::size_t rank = 0; rank < good; ++rank)
    if (plane.errors[plane.best_first[rank]] > squaredFar(plane))
      off_plane_.push_back(plane.best_first[rank]);
  if (off_plane_.size() < 2) return false;
  Candidate best;
  if (!improveByParallax(verifier, plane.homography, off_plane_, kPairs, random, best)) return false;
  optimizeLocally(FundamentalModel(), verifier, best);
  const Counts counts = count(plane, verifier, best.model);
  const bool many =
      counts.agreeing_off >= kShareOfPlane * counts.on && counts.agreeing_off >= kShareOfOff * counts.off;
  const bool most = counts.agreeing_off >= kOutnumbers * counts.on &&
                    counts.agreeing_off >= min_agreeing_share * counts.off;
  if (2 * counts.agreeing_on < counts.on || !(many || most)) return false;
  off_plane_.clear();
  for (std::uint32_t i = 0; i < n; ++i)
    if (plane.errors[i] > squaredFar(plane)) off_plane_.push_back(i);
  significance_.assign(plane.pixels.subset(off_plane_));
  fundamental = plane.matches.fundamentalToPixels(best.model);
  return isSignificant(significance_.fundamental(fundamental, kPairs).confidence);
}

}  // namespace corrsel::core
