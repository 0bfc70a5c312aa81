#include "search/significance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "corrsel/random.h"
#include "geometry/essential.h"
#include "geometry/homography.h"
#include "geometry/residual.h"
#include "geometry/rotation.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kThresholds = 8;
constexpr double kThreshold[kThresholds] = {1, 1.5, 2, 3, 4, 5, 7, 10};  // px
constexpr double kMaxThreshold = kThreshold[kThresholds - 1];
constexpr std::uint64_t kMinTests = 10000;   // hypotheses that count at least, because models are refined
constexpr std::size_t kMinRepaired = 20000;  // re-paired matches that are drawn at least
// In units of the image (length_unit.h).
constexpr double kPlaceRadius = 8;      // nearer points are the same place
constexpr double kLinePlaceRadius = 2;  // the same for epipolar lines
constexpr double kDensityRadius = 20;   // half the side of the square in which the density is measured
constexpr double kMinCell = 5;          // side of a cell of the density
constexpr double kCellsPerMatch = 8;    // cells of the density per match, at most
constexpr double kMinSpread = 1e-3;     // smallest product of principal variances over the squared sum
constexpr int kPredictors = 6;          // nearest selected matches from which a match is predicted

double logFactorial(double n) {
  if (n < 16) {
    double product = 1;
    for (int i = 2; i <= static_cast<int>(n); ++i) product *= i;
    return std::log(product);
  }
  constexpr double kHalfLogTwoPi = 0.91893853320467274178;
  const double inverse = 1 / n;  // Stirling's series
  return (n + 0.5) * std::log(n) - n + kHalfLogTwoPi +
         inverse * (1.0 / 12 - inverse * inverse * (1.0 / 360 - inverse * inverse / 1260));
}

/// -log10 of the probability that at least one of the expected false alarms occurs, 1 - exp(-NFA).
double confidenceFrom(double log10_nfa) {
  constexpr double kCertain = -10;  // the probability is the expected number below this
  if (log10_nfa < kCertain) return -log10_nfa;
  const double expected = std::pow(10.0, log10_nfa);
  const double log = expected < 1 ? std::log(-std::expm1(-expected)) : std::log1p(-std::exp(-expected));
  return std::abs(log) / std::log(10.0);
}

}  // namespace

double log10BinomialTail(std::size_t n, std::size_t k, double p) {
  if (k == 0 || p >= 1) return 0;
  if (k > n || p <= 0) return -std::numeric_limits<double>::infinity();
  const auto total = static_cast<double>(n), hits = static_cast<double>(k);
  const double q = (total - hits) * p / ((hits + 1) * (1 - p));  // ratio of consecutive terms
  if (q >= 1) return 0;
  const double term = logFactorial(total) - logFactorial(hits) - logFactorial(total - hits) +
                      hits * std::log(p) + (total - hits) * std::log1p(-p);
  return std::min(0.0, (term - std::log1p(-q)) / std::log(10.0));
}

void SignificanceTest::assign(const Correspondences& matches) {
  sortByCoordinates(matches, order_, scratch_);
  const std::size_t n = matches.size();
  const auto take = [&](const std::vector<float>& from, std::vector<float>& to) {
    to.resize(n);
    for (std::size_t i = 0; i < n; ++i) to[i] = from[order_[i].row];
  };
  take(matches.left_x, left_x_);
  take(matches.left_y, left_y_);
  take(matches.right_x, right_x_);
  take(matches.right_y, right_y_);
  double width = matches.right_size.width, height = matches.right_size.height, left = 0, top = 0;
  if ((width <= 0 || height <= 0) && n > 0) {
    const auto [low_x, high_x] = std::minmax_element(right_x_.begin(), right_x_.end());
    const auto [low_y, high_y] = std::minmax_element(right_y_.begin(), right_y_.end());
    left = *low_x;
    top = *low_y;
    width = static_cast<double>(*high_x) - *low_x;
    height = static_cast<double>(*high_y) - *low_y;
  }
  width = std::max(width, 1.0);
  height = std::max(height, 1.0);
  right_area_ = width * height;
  units_ = LengthUnits::of(matches);
  left_camera_ = matches.left_camera;
  right_camera_ = matches.right_camera;
  density_.build(right_x_, right_y_, {left, top, width, height}, units_.right);
}

void SignificanceTest::Density::build(const std::vector<float>& x, const std::vector<float>& y,
                                      const cv::Rect2d& area, double unit) {
  radius_ = kDensityRadius * unit;
  const double max_cells = kCellsPerMatch * static_cast<double>(x.size());
  const double cell = std::max(
      {kMinCell * unit, std::sqrt(area.area() / max_cells), area.width / max_cells, area.height / max_cells});
  grid_ = CellGrid::covering(area.x, area.y, area.width, area.height, cell);
  const auto stride = static_cast<std::size_t>(grid_.columns) + 1,
             rows = static_cast<std::size_t>(grid_.rows);
  sums_.assign(stride * (rows + 1), 0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto column = static_cast<std::size_t>(grid_.column(x[i])),
               row = static_cast<std::size_t>(grid_.row(y[i]));
    ++sums_[(row + 1) * stride + column + 1];
  }
  for (std::size_t row = 1; row <= rows; ++row) {
    std::uint32_t in_row = 0;
    for (std::size_t column = 1; column < stride; ++column) {
      in_row += sums_[row * stride + column];
      sums_[row * stride + column] = sums_[(row - 1) * stride + column] + in_row;
    }
  }
}

double SignificanceTest::Density::others(double x, double y, double own_x, double own_y) const {
  const double cell = grid_.cell_width;
  const double low_x = (x - grid_.left - radius_) / cell, high_x = (x - grid_.left + radius_) / cell;
  const double low_y = (y - grid_.top - radius_) / cell, high_y = (y - grid_.top + radius_) / cell;
  // One of the cells, or the end behind the last one.
  const auto below = [](double position, int count) { return CellGrid::clamped(position, count + 1); };
  const auto above = [below](double position, int count) {
    const int whole = below(position, count);
    return whole < count && whole < position ? whole + 1 : whole;
  };
  const int first_column = below(low_x, grid_.columns), end_column = above(high_x, grid_.columns);
  const int first_row = below(low_y, grid_.rows), end_row = above(high_y, grid_.rows);
  if (first_column >= end_column || first_row >= end_row) return 0;
  const auto at = [this](int row, int column) {
    return sums_[static_cast<std::size_t>(row) * (static_cast<std::size_t>(grid_.columns) + 1) +
                 static_cast<std::size_t>(column)];
  };
  double count = at(end_row, end_column) - at(first_row, end_column) - at(end_row, first_column) +
                 at(first_row, first_column);
  const int own_column = grid_.column(own_x), own_row = grid_.row(own_y);
  if (own_column >= first_column && own_column < end_column && own_row >= first_row && own_row < end_row)
    count -= 1;
  return count / (static_cast<double>(end_column - first_column) * (end_row - first_row) * cell * cell);
}

void SignificanceTest::addCandidate(double squared_error, std::size_t match) {
  if (squared_error <= kMaxThreshold * kMaxThreshold)
    candidates_.push_back({sortKey(static_cast<float>(squared_error)), static_cast<std::uint32_t>(match)});
}

/// Takes the candidates by rising error and counts those that begin and end where none taken before does.
void SignificanceTest::countDistinct(double place_radius) {
  radixSort(candidates_, scratch_);
  left_places_.clear(candidates_.size(), static_cast<float>(place_radius * units_.left));
  right_places_.clear(candidates_.size(), static_cast<float>(place_radius * units_.right));
  std::size_t count = 0, next = 0;
  for (std::size_t threshold = 0; threshold < kThresholds; ++threshold) {
    const std::uint32_t limit = sortKey(static_cast<float>(kThreshold[threshold] * kThreshold[threshold]));
    for (; next < candidates_.size() && candidates_[next].key <= limit; ++next) {
      const std::uint32_t i = candidates_[next].row;
      if (left_places_.isTaken(left_x_[i], left_y_[i]) || right_places_.isTaken(right_x_[i], right_y_[i]))
        continue;
      left_places_.add(left_x_[i], left_y_[i]);
      right_places_.add(right_x_[i], right_y_[i]);
      ++count;
    }
    counts_[threshold] = count;
  }
}

Significance SignificanceTest::evaluate(std::size_t trials, std::size_t sample_size, double log10_tests,
                                        const double* chance) const {
  Significance best;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kThresholds; ++i) {
    if (counts_[i] <= sample_size) continue;
    const double log10_nfa = log10_tests + log10BinomialTail(trials - sample_size, counts_[i] - sample_size,
                                                             std::min(1.0, chance[i]));
    if (log10_nfa >= lowest) continue;
    lowest = log10_nfa;
    best = {confidenceFrom(log10_nfa), kThreshold[i], counts_[i]};
  }
  return best;
}

/// Adds the probabilities that a match agrees by chance with the prediction (x, y), for discs of `area` times
/// their size.
void SignificanceTest::addChance(double x, double y, std::uint32_t match, double area, double* chance) const {
  const double others = density_.others(x, y, right_x_[match], right_y_[match]);
  const double density = std::max(1 / right_area_, others / static_cast<double>(left_x_.size() - 1));
  const double unit = density * kPi * area;
  for (std::size_t t = 0; t < kThresholds; ++t)
    chance[t] += std::min(1.0, unit * kThreshold[t] * kThreshold[t]);
}

Significance SignificanceTest::homography(const cv::Matx33d& left_to_right, std::uint64_t hypotheses) {
  constexpr std::size_t kSampleSize = 4;
  const std::size_t n = left_x_.size();
  const cv::Matx33d& h = left_to_right;
  const double determinant = cv::determinant(h);
  if (n <= kSampleSize || !(std::abs(determinant) > 0)) return {};
  const cv::Matx33d backward = adjugateOf(h) * (determinant > 0 ? 1.0 : -1.0);
  candidates_.clear();
  double chance[kThresholds] = {};
  for (std::size_t i = 0; i < n; ++i) {
    const double w = thirdCoordinate(h, left_x_[i], left_y_[i]);
    if (!(w > 0)) continue;
    const double forward = homographyError(h, left_x_[i], left_y_[i], right_x_[i], right_y_[i]);
    addCandidate(
        std::min(forward, homographyError(backward, right_x_[i], right_y_[i], left_x_[i], left_y_[i])), i);
    const double x = (h(0, 0) * left_x_[i] + h(0, 1) * left_y_[i] + h(0, 2)) / w;
    const double y = (h(1, 0) * left_x_[i] + h(1, 1) * left_y_[i] + h(1, 2)) / w;
    // The disc around the left point covers an area in the right image that is |det J| times as large.
    addChance(x, y, static_cast<std::uint32_t>(i), std::max(1.0, std::abs(determinant) / (w * w * w)),
              chance);
  }
  for (double& share : chance) share /= static_cast<double>(n);
  countDistinct(kPlaceRadius);
  const auto tests = static_cast<double>(kThresholds * std::max(kMinTests, hypotheses));
  return evaluate(n, kSampleSize, std::log10(tests), chance);
}

Significance SignificanceTest::fundamental(const cv::Matx33d& fundamental, std::uint64_t hypotheses) {
  constexpr std::size_t kSampleSize = 7, kMaxModels = 3;
  const std::size_t n = left_x_.size();
  if (n <= kSampleSize || !(cv::norm(fundamental) > 0)) return {};
  const auto errors = kernels().residuals.pixel_sampson;
  squared_errors_.resize(n);
  errors(fundamental.val, {left_x_.data(), left_y_.data(), right_x_.data(), right_y_.data(), n}, 0, n,
         squared_errors_.data());
  candidates_.clear();
  for (std::size_t i = 0; i < n; ++i) addCandidate(squared_errors_[i], i);
  repaired_x_.resize(n);
  repaired_y_.resize(n);
  double chance[kThresholds] = {};
  Random random(0);
  const std::size_t drawn = std::max(kMinRepaired, n);
  for (std::size_t begin = 0; begin < drawn; begin += n) {
    const std::size_t count = std::min(n, drawn - begin);
    for (std::size_t left = 0; left < count; ++left) {
      const std::size_t other = random.index(static_cast<std::uint32_t>(n - 1));
      const std::size_t right = other < left ? other : other + 1;
      repaired_x_[left] = right_x_[right];
      repaired_y_[left] = right_y_[right];
    }
    errors(fundamental.val, {left_x_.data(), left_y_.data(), repaired_x_.data(), repaired_y_.data(), count},
           0, count, squared_errors_.data());
    for (std::size_t i = 0; i < count; ++i) {
      const double squared = squared_errors_[i];
      // Most of them are beyond all thresholds.
      if (squared > kMaxThreshold * kMaxThreshold) continue;
      for (std::size_t t = 0; t < kThresholds; ++t)
        chance[t] += squared <= kThreshold[t] * kThreshold[t] ? 1.0 : 0.0;
    }
  }
  return evaluateLines(chance, drawn, kSampleSize, kMaxModels, hypotheses);
}

/// @param repaired  re-paired matches within each threshold, of `drawn`; receives the chances
Significance SignificanceTest::evaluateLines(double (&repaired)[kThresholds], std::size_t drawn,
                                             std::size_t sample_size, std::size_t max_models,
                                             std::uint64_t hypotheses) {
  const double uniform = 2 / std::sqrt(right_area_);  // per px, for a line as long as the image is wide
  double per_px = uniform;
  for (std::size_t t = kThresholds; t-- > 0;) {
    per_px = std::max(per_px, repaired[t] / static_cast<double>(drawn) / kThreshold[t]);
    repaired[t] = per_px * kThreshold[t];
  }
  countDistinct(kLinePlaceRadius);
  const auto tests = static_cast<double>(kThresholds * max_models * std::max(kMinTests, hypotheses));
  return evaluate(left_x_.size(), sample_size, std::log10(tests), repaired);
}

/// The rays in the order of the coordinates.
const RayMatches& SignificanceTest::rays() {
  unproject(*left_camera_, left_x_.data(), left_y_.data(), left_x_.size(), rays_.left);
  unproject(*right_camera_, right_x_.data(), right_y_.data(), right_x_.size(), rays_.right);
  return rays_;
}

Significance SignificanceTest::essential(const cv::Matx33d& essential, std::uint64_t hypotheses) {
  constexpr std::size_t kSampleSize = 5, kMaxModels = 10;
  const std::size_t n = left_x_.size();
  if (n <= kSampleSize || !(cv::norm(essential) > 0)) return {};
  const RayMatches& matches = rays();
  candidates_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const double error = tangentSampson(essential, matches, i);
    addCandidate(error * error, i);
  }
  Random random(0);
  rows_.resize(n);
  std::iota(rows_.begin(), rows_.end(), 0U);
  random.shuffle(rows_);
  shuffled_.take(matches, rows_);
  errors_.resize(n);
  double chance[kThresholds] = {};
  std::size_t drawn = 0;
  for (std::size_t shift = 1; shift < n && drawn < kMinRepaired; ++shift, drawn += n) {
    repairedErrors(essential, shuffled_, shift, errors_.data());
    for (const float squared : errors_) {
      for (std::size_t t = 0; t < kThresholds; ++t)
        chance[t] += squared <= kThreshold[t] * kThreshold[t] ? 1.0 : 0.0;
    }
  }
  return evaluateLines(chance, drawn, kSampleSize, kMaxModels, hypotheses);
}

Significance SignificanceTest::rotation(const cv::Matx33d& rotation, std::uint64_t hypotheses) {
  constexpr std::size_t kSampleSize = 2;
  const std::size_t n = left_x_.size();
  if (n <= kSampleSize) return {};
  const RayMatches& matches = rays();
  candidates_.clear();
  double chance[kThresholds] = {};
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Vec3d turned = rotation * matches.left.direction(i);
    addCandidate(squaredRotationError(rotation, matches, i), i);
    cv::Point2d seen;
    if (!project(*right_camera_, turned, seen)) continue;
    const double scale = matches.left.pixelAngle(i) / matches.right.pixelAngle(i);
    addChance(seen.x, seen.y, static_cast<std::uint32_t>(i), std::max(1.0, scale * scale), chance);
  }
  for (double& share : chance) share /= static_cast<double>(n);
  countDistinct(kPlaceRadius);
  const auto tests = static_cast<double>(kThresholds * std::max(kMinTests, hypotheses));
  return evaluate(n, kSampleSize, std::log10(tests), chance);
}

void SignificanceTest::gatherSelected(const std::vector<std::uint8_t>& mask) {
  selected_.clear();
  selected_x_.clear();
  selected_y_.clear();
  for (std::size_t i = 0; i < left_x_.size(); ++i) {
    if (mask[order_[i].row] == 0) continue;
    selected_.push_back(static_cast<std::uint32_t>(i));
    selected_x_.push_back(left_x_[i]);
    selected_y_.push_back(left_y_[i]);
  }
}

/// Draws whole places, so that no match is predicted from another one at its own place.
void SignificanceTest::drawHalves() {
  Random random(0);
  half_.resize(selected_.size());
  half_of_place_.clear();
  predictors_[0].clear();
  predictors_[1].clear();
  left_places_.clear(selected_.size(), static_cast<float>(kPlaceRadius * units_.left));
  for (std::size_t i = 0; i < selected_.size(); ++i) {
    std::uint32_t place = left_places_.findWithin(selected_x_[i], selected_y_[i]);
    if (place == PlaceIndex::kNone) {
      place = static_cast<std::uint32_t>(half_of_place_.size());
      left_places_.add(selected_x_[i], selected_y_[i]);
      half_of_place_.push_back(static_cast<std::uint8_t>(random.index(2)));
      predictors_[half_of_place_[place]].push_back(static_cast<std::uint32_t>(i));
    }
    half_[i] = half_of_place_[place];
  }
}

/// Computes where the affine map that fits the predictors best takes a match.
/// @return false if the predictors are nearly on a line
bool SignificanceTest::predict(std::uint32_t match, const std::uint32_t* predictors, double& x,
                               double& y) const {
  double mean_x = 0, mean_y = 0, mean_u = 0, mean_v = 0;
  for (int p = 0; p < kPredictors; ++p) {
    const std::uint32_t j = selected_[predictors[p]];
    mean_x += left_x_[j], mean_y += left_y_[j];
    mean_u += right_x_[j], mean_v += right_y_[j];
  }
  mean_x /= kPredictors, mean_y /= kPredictors, mean_u /= kPredictors, mean_v /= kPredictors;
  double xx = 0, xy = 0, yy = 0, xu = 0, yu = 0, xv = 0, yv = 0;
  for (int p = 0; p < kPredictors; ++p) {
    const std::uint32_t j = selected_[predictors[p]];
    const double dx = left_x_[j] - mean_x, dy = left_y_[j] - mean_y;
    const double du = right_x_[j] - mean_u, dv = right_y_[j] - mean_v;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
    xu += dx * du, yu += dy * du, xv += dx * dv, yv += dy * dv;
  }
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > kMinSpread * (xx + yy) * (xx + yy))) return false;
  const double dx = left_x_[match] - mean_x, dy = left_y_[match] - mean_y;
  const double a = (dx * yy - dy * xy) / determinant, b = (dy * xx - dx * xy) / determinant;
  x = mean_u + a * xu + b * yu;
  y = mean_v + a * xv + b * yv;
  return true;
}

Significance SignificanceTest::local(const std::vector<std::uint8_t>& mask) {
  gatherSelected(mask);
  drawHalves();
  const std::size_t n = left_x_.size(), count = selected_.size();
  if (std::min(predictors_[0].size(), predictors_[1].size()) < kPredictors) return {};
  Significance worst;
  for (std::uint8_t half = 0; half < 2; ++half) {
    const std::vector<std::uint32_t>& predictors = predictors_[half];
    predicted_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      if (half_[i] != half) predicted_.push_back(static_cast<std::uint32_t>(i));
    }
    const std::size_t predicted = predicted_.size();
    nearest_.resize(predicted * kPredictors);
    neighbours_.build(selected_x_.data(), selected_y_.data(), predictors.size(), kPredictors,
                      predictors.data());
    neighbours_.nearestToAll(selected_x_.data(), selected_y_.data(), predicted, kPredictors, nearest_.data(),
                             predicted_.data());
    candidates_.clear();
    double chance[kThresholds] = {};
    for (std::size_t i = 0; i < predicted; ++i) {
      const std::uint32_t match = selected_[predicted_[i]];
      double x = 0, y = 0;
      if (!predict(match, &nearest_[i * kPredictors], x, y)) continue;
      const double dx = x - right_x_[match], dy = y - right_y_[match];
      addCandidate(dx * dx + dy * dy, match);
      addChance(x, y, match, 1, chance);
    }
    for (double& share : chance) share /= static_cast<double>(predicted);
    countDistinct(kPlaceRadius);
    const std::size_t trials = predicted + (n - count + 1) / 2;
    const Significance found = evaluate(trials, 0, std::log10(static_cast<double>(kThresholds)), chance);
    if (half == 0 || found.confidence < worst.confidence) worst = found;
  }
  return worst;
}

double confidenceOf(const Correspondences& matches, const Selection& selection, std::uint64_t hypotheses,
                    Workspace& workspace) {
  if (std::none_of(selection.mask.begin(), selection.mask.end(), [](std::uint8_t m) { return m != 0; }))
    return 0;
  SignificanceTest& test = workspace.part<SignificanceTest>();
  test.assign(matches);
  switch (selection.model_kind) {
    case ModelKind::kHomography:
      return test.homography(selection.model, hypotheses).confidence;
    case ModelKind::kFundamental:
      return test.fundamental(selection.model, hypotheses).confidence;
    case ModelKind::kEssential:
      return test.essential(selection.model, hypotheses).confidence;
    case ModelKind::kRotation:
      return test.rotation(selection.model, hypotheses).confidence;
    case ModelKind::kNone:
      break;
  }
  return test.local(selection.mask).confidence;
}

}  // namespace corrsel::core
