#include "auto/parallax.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/gather.h"
#include "corrsel/random.h"
#include "geometry/fundamental.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/fundamental_model.h"
#include "search/local_optimization.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

constexpr int kPairs = 300;
// Of the displacements: they come from repeated structure. Those of a narrow band differ little anyway.
constexpr double kPeriodicNear = 0.65, kPeriodicFar = 0.6;
constexpr double kMinEvidence = 3;  // decades
constexpr double kTests = 2e4;      // two tests of at least 10^4 hypotheses, as SignificanceTest counts them
// Near the plane.
constexpr double kNearBegin = 0.6, kNearEnd = 5;  // times the threshold of the plane
constexpr double kDirectionWidth = 2.0 / 3;       // of the threshold of the fundamental matrix
constexpr double kCoherent = 0.3, kMostOfBand = 0.625;
constexpr double kMinShareOfPlane = 0.01, kJumpsShareOfPlane = 0.2;
// Far from the plane.
constexpr double kOffPlane = 3;  // times the threshold of the plane
constexpr std::size_t kMinGood = 100, kGoodShare = 8, kMinRepaired = 2000;
constexpr double kShareOfPlane = 0.5, kShareOfOff = 0.3, kOutnumbers = 1.25, kMinTimesChance = 8;

double squaredFar(const PlaneOfMatches& plane) {
  return kOffPlane * kOffPlane * plane.threshold * plane.threshold;
}

}  // namespace

bool ParallaxTest::find(const PlaneOfMatches& plane, double area, double threshold, std::uint64_t seed,
                        cv::Matx33d& fundamental) {
  const NormalizedMatches& m = plane.matches;
  const std::size_t n = m.size();
  const Verifier verifier(m, Residual::kSampson, threshold * m.scale, true);
  uniform_chance_ = 2 * std::sqrt(2.0) * threshold / std::sqrt(area);
  near_.gather(plane, kNearBegin, kNearEnd);
  far_.gather(plane, kOffPlane, std::numeric_limits<double>::infinity());
  const std::size_t good = std::min(n, std::max(kMinGood, n / kGoodShare));
  good_off_.clear();
  for (std::size_t rank = 0; rank < good; ++rank)
    if (plane.errors[plane.best_first[rank]] > squaredFar(plane)) good_off_.push_back(plane.best_first[rank]);
  const std::vector<std::uint32_t>* const pools[] = {&near_.members(), &good_off_};
  for (const std::vector<std::uint32_t>* const pool : pools) {
    if (pool->size() < 2) continue;
    // Pairs are drawn from the pool, and scored by it alone.
    gatherPool(m, *pool);
    const Verifier of_pool(pool_, Residual::kSampson, threshold * m.scale, true);
    Random random(seed);
    Candidate found, candidate;
    if (!improveByParallax(of_pool, plane.homography, positions_, kPairs, random, found)) continue;
    if (!verifier.improve(found.model, candidate) || !test(plane, verifier, threshold, candidate)) continue;
    fundamental = m.fundamentalToPixels(candidate.model);
    return true;
  }
  return false;
}

void ParallaxTest::gatherPool(const NormalizedMatches& m, const std::vector<std::uint32_t>& pool) {
  gather(m.left_x, pool, pool_.left_x);
  gather(m.left_y, pool, pool_.left_y);
  gather(m.right_x, pool, pool_.right_x);
  gather(m.right_y, pool, pool_.right_y);
  positions_.resize(pool.size());
  std::iota(positions_.begin(), positions_.end(), 0U);
}

/// Refines a candidate and tests whether it shows parallax.
bool ParallaxTest::test(const PlaneOfMatches& plane, const Verifier& verifier, double threshold,
                        Candidate& candidate) {
  optimizeLocally(FundamentalModel(), verifier, candidate);
  const Counts counts = count(plane, verifier, candidate.model);
  if (2 * counts.agreeing_on < counts.on) return false;
  return kMinEvidence <=
         (nearEvidence(plane, candidate.model, threshold, counts.on) +
          farEvidence(plane, verifier, candidate.model, threshold, counts) - std::log10(kTests));
}

double ParallaxTest::nearEvidence(const PlaneOfMatches& plane, const cv::Matx33d& fundamental,
                                  double threshold, double on) {
  const PlaneBand::Direction found = near_.direction(fundamental, kDirectionWidth * threshold);
  const double agreeing = found.share * static_cast<double>(near_.members().size());
  const bool jumps = found.share >= kMostOfBand && agreeing >= kJumpsShareOfPlane * on &&
                     near_.periodicity() < kPeriodicNear;
  const bool counts =
      !plane.ranked || (agreeing >= kMinShareOfPlane * on && (jumps || near_.coherence() >= kCoherent));
  return counts ? found.log_ratio / std::log(10.0) : 0;
}

double ParallaxTest::farEvidence(const PlaneOfMatches& plane, const Verifier& verifier,
                                 const cv::Matx33d& fundamental, double threshold, const Counts& counts) {
  const double agreeing = counts.agreeing_off, off = counts.off;
  if (plane.ranked && !(agreeing >= kShareOfPlane * counts.on && agreeing >= kShareOfOff * off) &&
      !(agreeing >= kOutnumbers * counts.on && agreeing >= kMinTimesChance * uniform_chance_ * off))
    return 0;
  if (agreeing <= 2) return 0;
  far_.direction(fundamental, kDirectionWidth * threshold);
  if (far_.periodicity() >= kPeriodicFar) return 0;
  const NormalizedMatches& m = plane.matches;
  off_.clear();
  for (std::uint32_t i = 0; i < m.size(); ++i)
    if (plane.errors[i] > squaredFar(plane)) off_.push_back(i);
  Random random(0);
  const std::size_t drawn = std::max(kMinRepaired, off_.size());
  std::size_t repaired = 0;
  for (std::size_t k = 0; k < drawn; ++k) {
    const std::uint32_t left = off_[k % off_.size()];
    const std::uint32_t right = off_[random.index(static_cast<std::uint32_t>(off_.size()))];
    if (left == right) continue;
    const double error =
        sampsonError(fundamental, m.left_x[left], m.left_y[left], m.right_x[right], m.right_y[right]);
    repaired += error <= verifier.squaredThreshold() ? 1 : 0;
  }
  const double chance = std::max(uniform_chance_, static_cast<double>(repaired) / static_cast<double>(drawn));
  return -log10BinomialTail(off_.size() - 2, static_cast<std::size_t>(agreeing) - 2, std::min(1.0, chance));
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

}  // namespace corrsel::core
