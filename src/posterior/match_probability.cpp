#include "posterior/match_probability.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "geometry/residual.h"
#include "posterior/noise_scale.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Weights of the log odds, fitted to all datasets of docs/selectors.md at once.
struct Weights {
  double constant, fundamental, near, local, near_local, low, near_low, ratio, left_over, other_motion,
      purity;
};
constexpr Weights kWithModel = {-1.96, -0.52, 3.13, 1.79, 2.02, -5.62, -2.45, -3.21, 7.53, 2.14, 0.74};
constexpr Weights kWithoutModel = {-2.53, 0, 0, 4.87, 0, -5.28, 0, -7.87, 0, 0, 0};

constexpr double kHomographyScale = 5;     // px: t
constexpr double kFundamentalScale = 2.5;  // px: t
constexpr double kNoiseCut = 2;            // times t: larger residuals do not count for the noise
constexpr double kHalfConfidence = 10;     // -log10 units
constexpr double kUsualRatio = 0.8;        // of descriptor distances; stands for unknown ones
constexpr double kLowRatio = 0.5, kHighRatio = 1;
constexpr double kMaxPurity = 2;
constexpr double kFarAway = 1e12;  // px^2

double probabilityOf(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

/// 1 where chance explains the answer, 0 where it is certain.
double doubtOf(double confidence) { return kHalfConfidence / (kHalfConfidence + confidence); }

/// Ratio of the descriptor distances of a match minus the usual one; 0 where it is not known.
double excessRatio(const Correspondences& matches, std::size_t match) {
  if (matches.distance.empty() || matches.second_distance.empty()) return 0;
  const double ratio = static_cast<double>(matches.distance[match]) / matches.second_distance[match];
  return std::isnan(ratio) ? 0 : std::clamp(ratio, kLowRatio, kHighRatio) - kUsualRatio;
}

/// How the matches of an answer agree with its model.
struct Agreement {
  std::size_t local = 0, near_local = 0;  ///< members of the extended local set, and those within t
  std::size_t near_others = 0, far_others = 0;
};

Agreement agreementOf(const std::vector<double>& errors, const std::vector<std::uint8_t>& extended,
                      double squared_scale) {
  Agreement result;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const bool near = errors[i] <= squared_scale;
    if (extended[i] != 0) {
      ++result.local;
      result.near_local += near ? 1 : 0;
    } else {
      ++(near ? result.near_others : result.far_others);
    }
  }
  return result;
}

}  // namespace

void MatchProbability::compute(const AnsweredMatches& answered) {
  sigma_ = std::numeric_limits<double>::quiet_NaN();
  probability_.assign(answered.matches.size(), 0);
  const bool selected = std::any_of(answered.mask.begin(), answered.mask.end(),
                                    [](std::uint8_t selected_match) { return selected_match != 0; });
  if (!selected) return;
  if (answered.kind == ModelKind::kNone)
    withoutModel(answered);
  else
    withModel(answered);
}

void MatchProbability::withoutModel(const AnsweredMatches& answered) {
  const Weights& weights = kWithoutModel;
  const double common = weights.constant + weights.low * doubtOf(answered.confidence);
  for (std::size_t i = 0; i < probability_.size(); ++i) {
    const double local = answered.support.extended()[i] != 0 ? weights.local : 0;
    probability_[i] =
        static_cast<float>(probabilityOf(common + local + weights.ratio * excessRatio(answered.matches, i)));
  }
}

void MatchProbability::withModel(const AnsweredMatches& answered) {
  const bool homography = answered.kind == ModelKind::kHomography;
  const double scale = homography ? kHomographyScale : kFundamentalScale, squared = scale * scale;
  errors_.resize(probability_.size());
  pixelErrors(homography ? Residual::kSmallerTransfer : Residual::kSampson, answered.model, answered.matches,
              errors_.data());
  const std::vector<std::uint8_t>& extended = answered.support.extended();
  const Agreement agreement = agreementOf(errors_, extended, squared);

  const double area = answered.support.area(), line = 2 / std::sqrt(area);
  const double density = homography ? 1 / area : line;  // of an outlier's residual, per px^2 or px
  const auto far = static_cast<double>(agreement.far_others);
  sigma_ =
      estimateNoiseScale(errors_, {homography ? 2 : 1, homography ? 8 : 7, kNoiseCut * scale, far * density})
          .sigma;

  const Weights& weights = kWithModel;
  const double chance = far * density * (homography ? kPi * squared : scale);
  const double purity = std::clamp(std::log((static_cast<double>(agreement.near_others) + 1) / (chance + 1)),
                                   -kMaxPurity, kMaxPurity);
  const double left_over = static_cast<double>(agreement.local - agreement.near_local + 1) /
                           static_cast<double>(agreement.local + 2);
  const double doubt = doubtOf(answered.confidence);
  const double common = weights.constant + (homography ? 0 : weights.fundamental) + weights.low * doubt;
  const double near_common = weights.near + weights.near_low * doubt;
  for (std::size_t i = 0; i < probability_.size(); ++i) {
    const double error = errors_[i] < kFarAway ? errors_[i] : kFarAway;  // also of infinite and NaN ones
    const double near = (squared - error) / (squared + error), off = (1 - near) / 2;
    double log_odds = common + near_common * near + weights.ratio * excessRatio(answered.matches, i);
    if (extended[i] != 0)
      log_odds += weights.local + weights.near_local * near + weights.left_over * left_over * off;
    else
      log_odds += weights.purity * purity;
    if (answered.mask[i] != 0) log_odds += weights.other_motion * off;
    probability_[i] = static_cast<float>(probabilityOf(log_odds));
  }
}

}  // namespace corrsel::core
