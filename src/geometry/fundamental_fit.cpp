#include "geometry/fundamental_fit.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "corrsel/random.h"
#include "geometry/fundamental.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 8;
constexpr int kSamples = 1000, kSteps = 50;

std::vector<double> squaredErrors(const cv::Matx33d& f, const Correspondences& matches) {
  std::vector<double> errors(matches.size());
  pixelErrors(Residual::kSampson, f, matches, errors.data());
  return errors;
}

double medianError(const cv::Matx33d& f, const Correspondences& matches) {
  std::vector<double> errors = squaredErrors(f, matches);
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

double sumOfErrors(const cv::Matx33d& f, const Correspondences& matches) {
  const std::vector<double> errors = squaredErrors(f, matches);
  return std::accumulate(errors.begin(), errors.end(), 0.0);
}

/// The best matrix of random samples, normalised.
std::optional<cv::Matx33d> bestOfSamples(const Correspondences& matches,
                                         const NormalizedMatches& normalized) {
  Random random(0);
  std::vector<std::uint32_t> order(matches.size());
  std::iota(order.begin(), order.end(), 0U);
  std::optional<cv::Matx33d> best;
  double smallest = std::numeric_limits<double>::infinity();
  for (int sample = 0; sample < kSamples; ++sample) {
    for (std::uint32_t i = 0; i < 7; ++i) {
      const std::uint32_t other = i + random.index(static_cast<std::uint32_t>(order.size()) - i);
      std::swap(order[i], order[other]);
    }
    if (!isValidFundamentalSample(normalized, order.data())) continue;
    cv::Matx33d candidates[3];
    const int count = fundamentalFromSeven(normalized, order.data(), candidates);
    for (int i = 0; i < count; ++i) {
      const double error = medianError(normalized.fundamentalToPixels(candidates[i]), matches);
      if (!(error < smallest)) continue;
      smallest = error;
      best = candidates[i];
    }
  }
  return best;
}

}  // namespace

std::optional<cv::Matx33d> fitFundamental(const Correspondences& matches) {
  if (matches.size() < kMinMatches) return std::nullopt;
  const NormalizedMatches normalized = normalizeMatches(matches);
  const std::optional<cv::Matx33d> first = bestOfSamples(matches, normalized);
  if (!first) return std::nullopt;
  cv::Matx33d fitted = *first;
  double smallest = sumOfErrors(normalized.fundamentalToPixels(fitted), matches);
  for (int step = 0; step < kSteps; ++step) {
    cv::Matx33d next = fitted;
    if (!refineFundamental(normalized, std::numeric_limits<float>::max(), next)) {
      if (step == 0) return std::nullopt;
      break;
    }
    const double sum = sumOfErrors(normalized.fundamentalToPixels(next), matches);
    if (!(sum < smallest)) break;
    smallest = sum;
    fitted = next;
  }
  return normalized.fundamentalToPixels(fitted);
}

}  // namespace corrsel::core
