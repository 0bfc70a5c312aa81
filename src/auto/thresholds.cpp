#include "auto/thresholds.h"

#include <algorithm>

#include "posterior/noise_scale.h"

namespace corrsel::core {
namespace {

constexpr double kHomography = 5, kFundamental = 1.5;  // px
constexpr double kCut = 3;                             // times the threshold

/// How the errors of a kind of model are distributed.
struct Kind {
  int dimensions, parameters;
  double quantile;    // the length of 97 % of residuals with a standard deviation of 1 in each coordinate
  double max_growth;  // times the threshold
};
constexpr Kind kTransfer = {2, 8, 2.6482, 1.5}, kSampson = {1, 7, 2.1701, 3};

void adapt(const std::vector<double>& errors, const Kind& kind, double& threshold) {
  const NoiseScale noise = estimateNoiseScale(errors, {kind.dimensions, kind.parameters, kCut * threshold});
  const double needed = kind.quantile * noise.sigma;
  // Not for NaN.
  if (needed > threshold) threshold = std::min(needed, kind.max_growth * threshold);
}

}  // namespace

Thresholds::Thresholds(const AutoOptions& options)
    : homography(options.threshold > 0 ? options.threshold : kHomography),
      fundamental(options.fundamental_threshold > 0 ? options.fundamental_threshold : kFundamental),
      adapts_homography_(options.threshold <= 0),
      adapts_fundamental_(options.fundamental_threshold <= 0) {}

void Thresholds::adaptHomography(const std::vector<double>& errors) {
  if (adapts_homography_) adapt(errors, kTransfer, homography);
}

void Thresholds::adaptFundamental(const std::vector<double>& errors) {
  if (adapts_fundamental_) adapt(errors, kSampson, fundamental);
}

void selectWithin(const std::vector<double>& errors, double threshold, std::vector<std::uint8_t>& mask) {
  mask.resize(errors.size());
  const double squared = threshold * threshold;
  for (std::size_t i = 0; i < errors.size(); ++i) mask[i] = errors[i] <= squared ? 1 : 0;
}

}  // namespace corrsel::core
