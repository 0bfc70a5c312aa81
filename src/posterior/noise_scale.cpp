#include "posterior/noise_scale.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kBins = 128;         // of the length of a residual: counts are exact, sums of lengths are not
constexpr double kMinSigma = 0.1;  // px: below it, rounding and interpolation of positions decide
constexpr double kMinRatio = 2;    // cut / sigma below which noise cannot be told from the background
constexpr std::size_t kCandidates = 16;  // of sigma, before the best one is refined
constexpr int kRefinements = 12;

/// Probability that an inlier's residual is within the cut, for x = cut / sigma.
double shareWithin(int dimensions, double x) {
  return dimensions == 2 ? -std::expm1(-x * x / 2) : std::erf(x / std::sqrt(2.0));
}

/// The mixture of inliers and outliers within the cut.
class TruncatedMixture {
 public:
  TruncatedMixture(const std::vector<double>& squared_residuals, const ResidualKind& kind) : kind_(kind) {
    std::array<std::uint32_t, kBins> histogram{};
    const double beyond = 1.001 * kind.cut * kind.cut;  // needs no root to be seen as outside
    for (const double squared : squared_residuals) {
      if (squared > beyond) continue;
      const double bin = std::sqrt(squared) / kind.cut * kBins;
      if (bin < kBins) ++histogram[static_cast<std::size_t>(bin)];
    }
    Eigen::Index used = 0;
    for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
      if (histogram[bin] == 0) continue;
      const double length = (static_cast<double>(bin) + 0.5) / kBins;
      squares_[used] = length * length;
      counts_[used++] = histogram[bin];
      total_ += histogram[bin];
    }
    squares_.conservativeResize(used);
    counts_.conservativeResize(used);
    const double volume = kind.dimensions == 2 ? kPi * kind.cut * kind.cut : kind.cut;
    max_share_ = total_ > 0 ? std::max(0.0, 1 - kind.background * volume / total_) : 0;
  }

  /// Expected number of inliers for the sigma given last.
  double inliers() const { return share_ * total_; }

  /// Log likelihood of x = cut / sigma with the best share of inliers, apart from a constant.
  double logLikelihood(double x) {
    // The density of an inlier divided by that of an outlier.
    const double peak = kind_.dimensions == 2 ? x * x / 2 : x * std::sqrt(2 / kPi);
    const double height = peak / shareWithin(kind_.dimensions, x);
    excess_ = height * (-x * x / 2 * squares_).exp() - 1;
    maximizeShare();
    return (counts_ * (1 + share_ * excess_).log()).sum();
  }

 private:
  /// The likelihood is concave in the share: Newton's method on its derivative, between bounds that close.
  void maximizeShare() {
    constexpr int kSteps = 12;
    constexpr double kNegligible = 1e-6;
    double low = 0, high = max_share_;
    share_ = high / 2;
    for (int step = 0; step < kSteps; ++step) {
      terms_ = excess_ / (1 + share_ * excess_);
      const double slope = (counts_ * terms_).sum(), curvature = (counts_ * terms_.square()).sum();
      (slope > 0 ? low : high) = share_;
      const double next = curvature > 0 ? share_ + slope / curvature : share_;
      const double before = share_;
      share_ = next > low && next < high ? next : (low + high) / 2;
      if (std::abs(share_ - before) < kNegligible) return;
    }
  }

  /// One number for each bin that holds residuals.
  using OfBins = Eigen::Array<double, Eigen::Dynamic, 1, 0, kBins, 1>;

  const ResidualKind& kind_;
  OfBins squares_ = OfBins(kBins), counts_ = OfBins(kBins);  // lengths by cut
  OfBins excess_, terms_;
  double total_ = 0, max_share_ = 0, share_ = 0;
};

/// Returns cut / sigma of the highest likelihood.
double bestRatio(TruncatedMixture& mixture, double max_ratio) {
  const double step = std::log(max_ratio / kMinRatio) / (kCandidates - 1);
  double best = 0, highest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kCandidates; ++i) {
    const double ratio = kMinRatio * std::exp(step * static_cast<double>(i));
    const double likelihood = mixture.logLikelihood(ratio);
    if (likelihood > highest) {
      highest = likelihood;
      best = ratio;
    }
  }
  // Golden section between the neighbours of the best candidate.
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double low = std::log(std::max(kMinRatio, best * std::exp(-step)));
  double high = std::log(std::min(max_ratio, best * std::exp(step)));
  double inner_low = high - golden * (high - low), inner_high = low + golden * (high - low);
  double at_low = mixture.logLikelihood(std::exp(inner_low));
  double at_high = mixture.logLikelihood(std::exp(inner_high));
  for (int i = 0; i < kRefinements; ++i) {
    if (at_low > at_high) {
      high = inner_high;
      inner_high = inner_low;
      at_high = at_low;
      inner_low = high - golden * (high - low);
      at_low = mixture.logLikelihood(std::exp(inner_low));
    } else {
      low = inner_low;
      inner_low = inner_high;
      at_low = at_high;
      inner_high = low + golden * (high - low);
      at_high = mixture.logLikelihood(std::exp(inner_high));
    }
  }
  return std::exp((low + high) / 2);
}

}  // namespace

NoiseScale estimateNoiseScale(const std::vector<double>& squared_residuals, const ResidualKind& kind) {
  TruncatedMixture mixture(squared_residuals, kind);
  const double ratio = bestRatio(mixture, std::max(kind.cut / kMinSigma, kMinRatio));
  mixture.logLikelihood(ratio);
  NoiseScale found{std::numeric_limits<double>::quiet_NaN(), mixture.inliers()};
  const double equations = kind.dimensions * found.inliers;
  if (!(equations > kind.parameters)) return found;
  const double corrected = kind.cut / ratio * std::sqrt(equations / (equations - kind.parameters));
  found.sigma = std::clamp(corrected, kMinSigma, kind.cut);
  return found;
}

}  // namespace corrsel::core
