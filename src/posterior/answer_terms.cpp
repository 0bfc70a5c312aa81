#include "posterior/answer_terms.h"

#include <algorithm>
#include <cmath>

#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kHalfConfidence = 10;  // -log10 units
constexpr double kUsualRatio = 0.8;     // of descriptor distances; stands for unknown ones
constexpr double kLowRatio = 0.5, kHighRatio = 1;
constexpr double kMaxPurity = 2;
constexpr double kFarAway = 1e12;  // px^2

/// Ratio of the descriptor distances of a match minus the usual one; 0 where it is not known.
double excessRatio(const Correspondences& matches, std::size_t match) {
  if (matches.distance.empty() || matches.second_distance.empty()) return 0;
  const double ratio = static_cast<double>(matches.distance[match]) / matches.second_distance[match];
  return std::isnan(ratio) ? 0 : std::clamp(ratio, kLowRatio, kHighRatio) - kUsualRatio;
}

CellGrid gridOver(const std::vector<float>& x, const std::vector<float>& y, int side) {
  const auto [low_x, high_x] = std::minmax_element(x.begin(), x.end());
  const auto [low_y, high_y] = std::minmax_element(y.begin(), y.end());
  const double width = static_cast<double>(*high_x) - *low_x, height = static_cast<double>(*high_y) - *low_y;
  return {*low_x, *low_y, std::max(width, 1.0) / side, std::max(height, 1.0) / side, side, side};
}

}  // namespace

double AnswerTerms::outlierDensity(const AnsweredMatches& answered) {
  const double area = answered.support.area();
  return mapsPoints(answered.kind) ? 1 / area : 2 / std::sqrt(area);
}

AnswerTerms::AnswerTerms(const AnsweredMatches& answered, const std::vector<double>& errors)
    : answered_(answered),
      errors_(errors),
      doubt_(kHalfConfidence / (kHalfConfidence + answered.confidence)) {
  const double scale = mapsPoints(answered.kind) ? kHomographyScale : kFundamentalScale;
  squared_scale_ = scale * scale;
  if (answered.kind != ModelKind::kNone) countAgreements();
}

void AnswerTerms::countAgreements() {
  const Correspondences& matches = answered_.matches;
  grid_ = gridOver(matches.left_x, matches.left_y, kSide);
  std::size_t near_others = 0;
  for (std::size_t i = 0; i < errors_.size(); ++i) {
    const bool near = errors_[i] <= squared_scale_;
    if (answered_.support.extended()[i] == 0) {
      ++(near ? near_others : far_others_);
      continue;
    }
    const std::size_t cell = grid_.cell(matches.left_x[i], matches.left_y[i]);
    ++members_[cell];
    far_members_[cell] += near ? 0 : 1;
  }
  const double reach = mapsPoints(answered_.kind) ? kPi * squared_scale_ : std::sqrt(squared_scale_);
  const double chance = static_cast<double>(far_others_) * outlierDensity(answered_) * reach;
  purity_ =
      std::clamp(std::log((static_cast<double>(near_others) + 1) / (chance + 1)), -kMaxPurity, kMaxPurity);
}

/// Share of the members of the extended local set around a match that are off the model, in (0, 1).
double AnswerTerms::leftOverAt(std::size_t match) const {
  const std::size_t cell = grid_.cell(answered_.matches.left_x[match], answered_.matches.left_y[match]);
  return (far_members_[cell] + 0.5) / (members_[cell] + 1);
}

ProbabilityTerms AnswerTerms::of(std::size_t match) const {
  const double local = answered_.support.extended()[match] != 0 ? 1 : 0;
  const double ratio = excessRatio(answered_.matches, match);
  if (answered_.kind == ModelKind::kNone) return {1, 0, 0, local, 0, doubt_, 0, ratio, 0, 0, 0};
  // Infinite and NaN errors are far away, too.
  const double error = errors_[match] < kFarAway ? errors_[match] : kFarAway;
  const double near = (squared_scale_ - error) / (squared_scale_ + error), off = (1 - near) / 2;
  return {1,
          mapsPoints(answered_.kind) ? 0.0 : 1.0,
          near,
          local,
          near * local,
          doubt_,
          near * doubt_,
          ratio,
          local > 0 ? 0 : purity_,
          local > 0 ? leftOverAt(match) * off * off : 0,
          answered_.mask[match] != 0 ? off * off : 0};
}

}  // namespace corrsel::core
