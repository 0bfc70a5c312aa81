#include "auto/parallax.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/gather.h"
#include "geometry/homography.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/fundamental_model.h"
#include "search/local_optimization.h"

namespace corrsel::core {
namespace {

constexpr int kPairs = 300;
// Near the plane.
constexpr double kBandBegin = 0.6, kBandEnd = 5;  // times the threshold of the plane
constexpr double kTrustedShare = 0.75;            // of the matches on the plane
constexpr float kPlace = 4.0F;                    // px
constexpr std::size_t kMinBand = 6;
constexpr double kDirectionWidth = 2.0 / 3;  // of the threshold of the fundamental matrix
constexpr double kTests = 24e4;              // as SignificanceTest::fundamental() counts them at least
constexpr double kMinShareOfPlane = 0.01;
// Far from the plane.
constexpr double kOffPlane = 3;  // times the threshold of the plane
constexpr std::size_t kMinGood = 100, kGoodShare = 8;
constexpr double kShareOfPlane = 0.5, kShareOfOff = 0.1, kOutnumbers = 1.25, kMinTimesChance = 8;

/// ln((s + (1 - s) p) / p) for the agreeing and ln(1 - s) for the others, summed up, at the best s.
double logLikelihoodRatio(const std::vector<double>& chance_of_agreeing, std::size_t others, double& share) {
  double best = 0;
  share = 0;
  for (int step = 1; step < 20; ++step) {
    const double s = 0.05 * step;
    double sum = static_cast<double>(others) * std::log1p(-s);
    for (const double p : chance_of_agreeing) sum += std::log(s / p + 1 - s);
    if (sum <= best) continue;
    best = sum;
    share = s;
  }
  return best;
}

}  // namespace

bool ParallaxTest::find(const Input& input, cv::Matx33d& fundamental) {
  const Verifier verifier(input.matches, Residual::kSampson,
                          input.fundamental_threshold * input.matches.scale, true);
  return findNear(input, verifier, fundamental) || findFar(input, verifier, fundamental);
}

/// Writes the trusted matches that the plane misses by little, at distinct places, best first.
void ParallaxTest::gatherBand(const Input& input) {
  const double threshold = input.homography_threshold, begin = kBandBegin * threshold, end = kBandEnd * threshold;
  std::size_t on = 0, trusted_on = 0;
  for (const double error : input.errors) on += error <= threshold * threshold ? 1 : 0;
  const double share = input.ranked ? kTrustedShare : 1;
  const auto enough = static_cast<std::size_t>(share * static_cast<double>(on));
  band_.clear();
  left_places_.clear(64, kPlace);
  right_places_.clear(64, kPlace);
  for (const std::uint32_t i : input.best_first) {
    const double error = input.errors[i];
    if (input.ranked && trusted_on >= enough) break;
    trusted_on += error <= threshold * threshold ? 1 : 0;
    if (!(error > begin * begin && error <= end * end)) continue;
    const Correspondences& m = input.pixels;
    if (left_places_.isTaken(m.left_x[i], m.left_y[i]) || right_places_.isTaken(m.right_x[i], m.right_y[i]))
      continue;
    left_places_.add(m.left_x[i], m.left_y[i]);
    right_places_.add(m.right_x[i], m.right_y[i]);
    band_.push_back(i);
  }
}

/// G of the band.
double ParallaxTest::directionEvidence(const Input& input, const cv::Matx33d& f, double& share) const {
  const NormalizedMatches& m = input.matches;
  const double width = kDirectionWidth * input.fundamental_threshold * m.scale;
  std::vector<double> chance_of_agreeing;
  std::size_t others = 0;
  for (const std::uint32_t i : band_) {
    const cv::Vec3d left(m.left_x[i], m.left_y[i], 1), right(m.right_x[i], m.right_y[i], 1);
    const cv::Vec3d line = f * left, left_line = f.t() * right, on_plane = input.plane * left;
    const double squared_right = line[0] * line[0] + line[1] * line[1];
    const double squared = squared_right + left_line[0] * left_line[0] + left_line[1] * left_line[1];
    if (!(squared_right > 0)) continue;
    if (std::abs(line.dot(right)) > width * std::sqrt(squared)) {
      ++others;
      continue;
    }
    const double r = std::hypot(on_plane[0] / on_plane[2] - right[0], on_plane[1] / on_plane[2] - right[1]);
    const double sine = std::min(1.0, width * std::sqrt(squared / squared_right) / r);
    chance_of_agreeing.push_back(std::clamp(2 / CV_PI * std::asin(sine), 1e-6, 1.0));
  }
  return logLikelihoodRatio(chance_of_agreeing, others, share);
}

/// Counts the matches on the plane and off it, farther than `far` px, at distinct places.
ParallaxTest::Counts ParallaxTest::count(const Input& input, const Verifier& verifier,
                                         const cv::Matx33d& fundamental, double far) {
  const std::size_t n = input.matches.size();
  errors_.resize(n);
  modelErrors(Residual::kSampson, fundamental, input.matches, 0, n, errors_.data());
  for (std::vector<std::uint8_t>* const mask : {&off_agreeing_, &on_, &on_agreeing_}) {
    // Not assign(), of which GCC 14 assumes that it gets a size beyond all memory, and warns.
    mask->resize(n);
    std::fill(mask->begin(), mask->end(), std::uint8_t{0});
  }
  Counts counts;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t agrees = errors_[i] <= verifier.squaredThreshold() ? 1 : 0;
    if (input.errors[i] > far * far) {
      ++counts.off;
      off_agreeing_[i] = agrees;
    } else if (input.errors[i] <= input.homography_threshold * input.homography_threshold) {
      on_[i] = 1;
      on_agreeing_[i] = agrees;
    }
  }
  counts.agreeing_off = static_cast<double>(cells_.count(input.pixels, off_agreeing_));
  counts.on = static_cast<double>(cells_.count(input.pixels, on_));
  counts.agreeing_on = static_cast<double>(cells_.count(input.pixels, on_agreeing_));
  return counts;
}

bool ParallaxTest::findNear(const Input& input, const Verifier& verifier, cv::Matx33d& fundamental) {
  gatherBand(input);
  if (band_.size() < kMinBand) return false;
  // Samples are drawn from the band alone, and scored by it.
  const NormalizedMatches& m = input.matches;
  gather(m.left_x, band_, band_matches_.left_x);
  gather(m.left_y, band_, band_matches_.left_y);
  gather(m.right_x, band_, band_matches_.right_x);
  gather(m.right_y, band_, band_matches_.right_y);
  positions_.resize(band_.size());
  std::iota(positions_.begin(), positions_.end(), 0U);
  const Verifier of_band(band_matches_, Residual::kSampson, input.fundamental_threshold * m.scale, true);
  Random random(input.seed);
  Candidate in_band, best;
  if (!improveByParallax(of_band, input.plane, positions_, kPairs, random, in_band)) return false;
  if (!verifier.improve(in_band.model, best)) return false;
  optimizeLocally(FundamentalModel(), verifier, best);
  double share = 0;
  const double evidence = directionEvidence(input, best.model, share);
  if (!isSignificant((evidence - std::log(kTests)) / std::log(10.0))) return false;
  const Counts counts = count(input, verifier, best.model, kOffPlane * input.homography_threshold);
  if (share * static_cast<double>(band_.size()) < kMinShareOfPlane * counts.on ||
      2 * counts.agreeing_on < counts.on) {
    return false;
  }
  fundamental = m.fundamentalToPixels(best.model);
  return true;
}

bool ParallaxTest::findFar(const Input& input, const Verifier& verifier, cv::Matx33d& fundamental) {
  const std::size_t n = input.matches.size();
  const std::size_t good = std::min(n, std::max(kMinGood, n / kGoodShare));
  const double far = kOffPlane * input.homography_threshold;
  off_plane_.clear();
  for (std::size_t rank = 0; rank < good; ++rank)
    if (input.errors[input.best_first[rank]] > far * far) off_plane_.push_back(input.best_first[rank]);
  if (off_plane_.size() < 2) return false;
  Random random(input.seed);
  Candidate best;
  if (!improveByParallax(verifier, input.plane, off_plane_, kPairs, random, best)) return false;
  optimizeLocally(FundamentalModel(), verifier, best);
  const Counts counts = count(input, verifier, best.model, far);
  const auto off = static_cast<double>(counts.off);
  const double chance = 2 * std::sqrt(2.0) * input.fundamental_threshold / std::sqrt(input.area);
  const bool many = counts.agreeing_off >= kShareOfPlane * counts.on && counts.agreeing_off >= kShareOfOff * off;
  const bool most =
      counts.agreeing_off >= kOutnumbers * counts.on && counts.agreeing_off >= kMinTimesChance * chance * off;
  if (2 * counts.agreeing_on < counts.on || !(many || most)) return false;
  off_plane_.clear();
  for (std::uint32_t i = 0; i < n; ++i)
    if (input.errors[i] > far * far) off_plane_.push_back(i);
  significance_.assign(input.pixels.subset(off_plane_));
  const cv::Matx33d candidate = input.matches.fundamentalToPixels(best.model);
  if (!isSignificant(significance_.fundamental(candidate, kPairs).confidence)) return false;
  fundamental = candidate;
  return true;
}

}  // namespace corrsel::core
