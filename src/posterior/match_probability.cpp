#include "posterior/match_probability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "geometry/residual.h"
#include "points/cell_grid.h"
#include "posterior/noise_scale.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Weights of the log odds, fitted to all datasets of docs/selectors.md at once.
struct Weights {
  double constant, fundamental, near, local, near_local, doubt, near_doubt, ratio, purity, left_over,
      other_motion;
};
constexpr Weights kWithModel = {-1.94, -0.69, 3.22, 1.99, 2.22, -4.55, -1.91, -2.57, 0.75, 4.58, 3.43};
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

/// The matches outside of the extended local set by their distance from the model.
struct Others {
  std::size_t near = 0, far = 0;  ///< within t, and farther away
};

Others othersOf(const std::vector<double>& errors, const std::vector<std::uint8_t>& extended,
                double squared_scale) {
  Others result;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (extended[i] == 0) ++(errors[i] <= squared_scale ? result.near : result.far);
  return result;
}

/// What a model leaves over of the extended local set, in parts of the left image.
class LeftOver {
 public:
  LeftOver(const Correspondences& matches, const std::vector<double>& errors,
           const std::vector<std::uint8_t>& extended, double squared_scale)
      : grid_(over(matches)) {
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (extended[i] == 0) continue;
      const std::size_t cell = grid_.cell(matches.left_x[i], matches.left_y[i]);
      ++all_[cell];
      far_[cell] += errors[i] <= squared_scale ? 0 : 1;
    }
  }

  /// Share of those around a point that are off the model, in (0, 1); 1/2 where there are none.
  double shareAt(float x, float y) const {
    const std::size_t cell = grid_.cell(x, y);
    return (far_[cell] + 0.5) / (all_[cell] + 1);
  }

 private:
  static constexpr int kSide = 8;  // cells

  static CellGrid over(const Correspondences& matches) {
    const auto [low_x, high_x] = std::minmax_element(matches.left_x.begin(), matches.left_x.end());
    const auto [low_y, high_y] = std::minmax_element(matches.left_y.begin(), matches.left_y.end());
    const double width = static_cast<double>(*high_x) - *low_x,
                 height = static_cast<double>(*high_y) - *low_y;
    return {*low_x, *low_y, std::max(width, 1.0) / kSide, std::max(height, 1.0) / kSide, kSide, kSide};
  }

  CellGrid grid_;
  std::array<std::uint32_t, kSide * kSide> all_{}, far_{};
};

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
  const double common = weights.constant + weights.doubt * doubtOf(answered.confidence);
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
  const Others others = othersOf(errors_, extended, squared);
  const auto far = static_cast<double>(others.far);
  const double area = answered.support.area();
  const double density = homography ? 1 / area : 2 / std::sqrt(area);  // of outliers, per px^2 or px
  sigma_ =
      estimateNoiseScale(errors_, {homography ? 2 : 1, homography ? 8 : 7, kNoiseCut * scale, far * density})
          .sigma;

  const Weights& weights = kWithModel;
  const double chance = far * density * (homography ? kPi * squared : scale);
  const double excess = std::log((static_cast<double>(others.near) + 1) / (chance + 1));
  const double purity = weights.purity * std::clamp(excess, -kMaxPurity, kMaxPurity);
  const double doubt = doubtOf(answered.confidence);
  const double common = weights.constant + (homography ? 0 : weights.fundamental) + weights.doubt * doubt;
  const double near_common = weights.near + weights.near_doubt * doubt;
  const LeftOver left_over(answered.matches, errors_, extended, squared);
  for (std::size_t i = 0; i < probability_.size(); ++i) {
    const double error = errors_[i] < kFarAway ? errors_[i] : kFarAway;  // also of infinite and NaN ones
    const double near = (squared - error) / (squared + error), off = (1 - near) / 2;
    double log_odds = common + near_common * near + weights.ratio * excessRatio(answered.matches, i);
    if (extended[i] != 0) {
      const double share = left_over.shareAt(answered.matches.left_x[i], answered.matches.left_y[i]);
      log_odds += weights.local + weights.near_local * near + weights.left_over * share * off * off;
    } else {
      log_odds += purity;
    }
    if (answered.mask[i] != 0) log_odds += weights.other_motion * off * off;
    probability_[i] = static_cast<float>(probabilityOf(log_odds));
  }
}

}  // namespace corrsel::core
