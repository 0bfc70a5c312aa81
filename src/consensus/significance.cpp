#include "consensus/significance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/workspace_scope.h"
#include "corrsel/random.h"
#include "geometry/fundamental.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kThresholds = 8;
constexpr double kThreshold[kThresholds] = {1, 1.5, 2, 3, 4, 5, 7, 10};  // px
constexpr double kLargestThreshold = kThreshold[kThresholds - 1];
constexpr std::uint64_t kLeastTests = 10000;
constexpr std::size_t kLeastRepaired = 20000;
constexpr float kPlaceRadius = 8.0F;   // px: nearer points are the same place
constexpr double kDensityRadius = 20;  // px: half the side of the square in which the density is measured
constexpr double kLeastCell = 5;       // px: side of a cell of the density
constexpr double kCellsPerMatch = 8;   // at most
constexpr int kPredictors = 6;         // nearest selected matches from which a match is predicted

/// The cell of a position, at least 0 and at most `last`.
int clampCell(double position, int last) {
  return static_cast<int>(std::clamp(position, 0.0, static_cast<double>(last)));
}

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

void SignificanceTest::Places::clear(std::size_t most) {
  std::size_t size = 16;
  while (size < 2 * most) size *= 2;
  first_.assign(size, 0);
  points_.clear();
}

std::size_t SignificanceTest::Places::slot(std::int32_t cell_x, std::int32_t cell_y) const {
  const std::uint64_t cell = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell_x)) << 32 |
                             static_cast<std::uint32_t>(cell_y);
  return static_cast<std::size_t>(cell * 0x9E3779B97F4A7C15U >> 32) & (first_.size() - 1);
}

std::uint32_t SignificanceTest::Places::find(float x, float y) const {
  const auto cell_x = static_cast<std::int32_t>(std::floor(x / kPlaceRadius));
  const auto cell_y = static_cast<std::int32_t>(std::floor(y / kPlaceRadius));
  for (std::int32_t cy = cell_y - 1; cy <= cell_y + 1; ++cy) {
    for (std::int32_t cx = cell_x - 1; cx <= cell_x + 1; ++cx) {
      for (std::uint32_t i = first_[slot(cx, cy)]; i != 0; i = points_[i - 1].next) {
        const Point& point = points_[i - 1];
        const float dx = point.x - x, dy = point.y - y;
        if (dx * dx + dy * dy < kPlaceRadius * kPlaceRadius) return i - 1;
      }
    }
  }
  return kNone;
}

void SignificanceTest::Places::add(float x, float y) {
  const auto cell_x = static_cast<std::int32_t>(std::floor(x / kPlaceRadius));
  const auto cell_y = static_cast<std::int32_t>(std::floor(y / kPlaceRadius));
  std::uint32_t& first = first_[slot(cell_x, cell_y)];
  points_.push_back({x, y, cell_x, cell_y, first});
  first = static_cast<std::uint32_t>(points_.size());
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
  density_.build(right_x_, right_y_, left, top, width, height);
}

void SignificanceTest::Density::build(const std::vector<float>& x, const std::vector<float>& y, double left,
                                      double top, double width, double height) {
  left_ = left;
  top_ = top;
  const double most = kCellsPerMatch * static_cast<double>(x.size());
  cell_ = std::max({kLeastCell, std::sqrt(width * height / most), width / most, height / most});
  columns_ = static_cast<int>(width / cell_) + 1;
  rows_ = static_cast<int>(height / cell_) + 1;
  const auto stride = static_cast<std::size_t>(columns_) + 1;
  sums_.assign(stride * (static_cast<std::size_t>(rows_) + 1), 0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const int column = clampCell((x[i] - left_) / cell_, columns_ - 1);
    const int row = clampCell((y[i] - top_) / cell_, rows_ - 1);
    ++sums_[(static_cast<std::size_t>(row) + 1) * stride + static_cast<std::size_t>(column) + 1];
  }
  for (std::size_t row = 1; row <= static_cast<std::size_t>(rows_); ++row) {
    std::uint32_t in_row = 0;
    for (std::size_t column = 1; column < stride; ++column) {
      in_row += sums_[row * stride + column];
      sums_[row * stride + column] = sums_[(row - 1) * stride + column] + in_row;
    }
  }
}

double SignificanceTest::Density::others(double x, double y, double own_x, double own_y) const {
  const double low_x = (x - left_ - kDensityRadius) / cell_, high_x = (x - left_ + kDensityRadius) / cell_;
  const double low_y = (y - top_ - kDensityRadius) / cell_, high_y = (y - top_ + kDensityRadius) / cell_;
  const int first_column = clampCell(low_x, columns_), end_column = clampCell(std::ceil(high_x), columns_);
  const int first_row = clampCell(low_y, rows_), end_row = clampCell(std::ceil(high_y), rows_);
  if (first_column >= end_column || first_row >= end_row) return 0;
  const auto at = [this](int row, int column) {
    return sums_[static_cast<std::size_t>(row) * (static_cast<std::size_t>(columns_) + 1) +
                 static_cast<std::size_t>(column)];
  };
  double count = at(end_row, end_column) - at(first_row, end_column) - at(end_row, first_column) +
                 at(first_row, first_column);
  const int own_column = clampCell((own_x - left_) / cell_, columns_ - 1);
  const int own_row = clampCell((own_y - top_) / cell_, rows_ - 1);
  if (own_column >= first_column && own_column < end_column && own_row >= first_row && own_row < end_row)
    count -= 1;
  return count / (static_cast<double>(end_column - first_column) * (end_row - first_row) * cell_ * cell_);
}

void SignificanceTest::addCandidate(double squared_error, std::size_t match) {
  if (squared_error <= kLargestThreshold * kLargestThreshold)
    candidates_.push_back({sortKey(static_cast<float>(squared_error)), static_cast<std::uint32_t>(match)});
}

/// Takes the candidates by rising error and counts those that begin and end where none taken before does.
void SignificanceTest::countDistinct() {
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    return a.key != b.key ? a.key < b.key : a.match < b.match;
  });
  left_places_.clear(candidates_.size());
  right_places_.clear(candidates_.size());
  std::size_t count = 0, next = 0;
  for (std::size_t threshold = 0; threshold < kThresholds; ++threshold) {
    const std::uint32_t limit = sortKey(static_cast<float>(kThreshold[threshold] * kThreshold[threshold]));
    for (; next < candidates_.size() && candidates_[next].key <= limit; ++next) {
      const std::uint32_t i = candidates_[next].match;
      if (left_places_.isTaken(left_x_[i], left_y_[i]) || right_places_.isTaken(right_x_[i], right_y_[i]))
        continue;
      left_places_.add(left_x_[i], left_y_[i]);
      right_places_.add(right_x_[i], right_y_[i]);
      ++count;
    }
    counts_[threshold] = count;
  }
}

Significance SignificanceTest::judge(std::size_t trials, std::size_t sample_size, double log10_tests,
                                     const double* chance) const {
  Significance best;
  for (std::size_t i = 0; i < kThresholds; ++i) {
    if (counts_[i] <= sample_size) continue;
    const double confidence = -log10_tests - log10BinomialTail(trials - sample_size, counts_[i] - sample_size,
                                                               std::min(1.0, chance[i]));
    if (confidence > best.confidence) best = {confidence, kThreshold[i], counts_[i]};
  }
  return best;
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
    const double density = std::max(
        1 / right_area_, density_.others(x, y, right_x_[i], right_y_[i]) / static_cast<double>(n - 1));
    // The disc around the left point covers an area in the right image that is |det J| times as large.
    const double unit = density * kPi * std::max(1.0, std::abs(determinant) / (w * w * w));
    for (std::size_t t = 0; t < kThresholds; ++t)
      chance[t] += std::min(1.0, unit * kThreshold[t] * kThreshold[t]);
  }
  for (double& share : chance) share /= static_cast<double>(n);
  countDistinct();
  const auto tests = static_cast<double>(kThresholds * std::max(kLeastTests, hypotheses));
  return judge(n, kSampleSize, std::log10(tests), chance);
}

Significance SignificanceTest::fundamental(const cv::Matx33d& fundamental, std::uint64_t hypotheses) {
  constexpr std::size_t kSampleSize = 7, kMostModels = 3;
  const std::size_t n = left_x_.size();
  if (n <= kSampleSize || !(cv::norm(fundamental) > 0)) return {};
  candidates_.clear();
  const auto error = [&](std::size_t left, std::size_t right) {
    return sampsonError(fundamental, left_x_[left], left_y_[left], right_x_[right], right_y_[right]);
  };
  for (std::size_t i = 0; i < n; ++i) addCandidate(error(i, i), i);
  double chance[kThresholds] = {};
  Random random(0);
  const std::size_t drawn = std::max(kLeastRepaired, n);
  for (std::size_t i = 0; i < drawn; ++i) {
    const std::size_t left = i % n, other = random.index(static_cast<std::uint32_t>(n - 1));
    const double squared = error(left, other < left ? other : other + 1);
    for (std::size_t t = 0; t < kThresholds; ++t)
      chance[t] += squared <= kThreshold[t] * kThreshold[t] ? 1.0 : 0.0;
  }
  const double uniform = 2 / std::sqrt(right_area_);  // per px, for a line as long as the image is wide
  double per_px = uniform;
  for (std::size_t t = kThresholds; t-- > 0;) {
    per_px = std::max(per_px, chance[t] / static_cast<double>(drawn) / kThreshold[t]);
    chance[t] = per_px * kThreshold[t];
  }
  countDistinct();
  const auto tests = static_cast<double>(kThresholds * kMostModels * std::max(kLeastTests, hypotheses));
  return judge(n, kSampleSize, std::log10(tests), chance);
}

Significance SignificanceTest::local(const std::vector<std::uint8_t>& mask) {
  const std::size_t n = left_x_.size();
  // Whole places are drawn, so that no match is predicted from another one at its own place.
  half_of_place_.clear();
  half_.resize(n);
  left_places_.clear(n);
  Random random(0);
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t place = left_places_.find(left_x_[i], left_y_[i]);
    if (place == Places::kNone) {
      place = static_cast<std::uint32_t>(half_of_place_.size());
      left_places_.add(left_x_[i], left_y_[i]);
      half_of_place_.push_back(static_cast<std::uint8_t>(random.index(2)));
    }
    half_[i] = half_of_place_[place];
  }
  Significance worst;
  for (std::uint8_t half = 0; half < 2; ++half) {
    members_.clear();
    left_places_.clear(n);
    for (std::size_t i = 0; i < n; ++i) {
      if (half_[i] != half || mask[order_[i].row] == 0 || left_places_.isTaken(left_x_[i], left_y_[i]))
        continue;
      left_places_.add(left_x_[i], left_y_[i]);
      members_.push_back(static_cast<std::uint32_t>(i));
    }
    if (members_.size() < kPredictors) return {};
    neighbours_.build(left_x_.data(), left_y_.data(), members_.size(), kPredictors, members_.data());
    nearest_.resize(kPredictors);
    candidates_.clear();
    std::size_t trials = 0;
    double chance[kThresholds] = {};
    for (std::size_t i = 0; i < n; ++i) {
      if (half_[i] == half) continue;
      ++trials;
      neighbours_.nearest(left_x_[i], left_y_[i], kPredictors, nearest_.data());
      double mean[4] = {}, xx = 0, xy = 0, yy = 0, xu = 0, yu = 0, xv = 0, yv = 0;
      for (const std::uint32_t j : nearest_) {
        const double values[4] = {left_x_[j], left_y_[j], right_x_[j], right_y_[j]};
        for (int c = 0; c < 4; ++c) mean[c] += values[c] / kPredictors;
      }
      for (const std::uint32_t j : nearest_) {
        const double x = left_x_[j] - mean[0], y = left_y_[j] - mean[1];
        const double u = right_x_[j] - mean[2], v = right_y_[j] - mean[3];
        xx += x * x, xy += x * y, yy += y * y;
        xu += x * u, yu += y * u, xv += x * v, yv += y * v;
      }
      const double determinant = xx * yy - xy * xy;
      if (!(determinant > 1e-3 * (xx + yy) * (xx + yy))) continue;  // on a line
      const double dx = left_x_[i] - mean[0], dy = left_y_[i] - mean[1];
      const double a = (dx * yy - dy * xy) / determinant, b = (dy * xx - dx * xy) / determinant;
      const double u = mean[2] + a * xu + b * yu, v = mean[3] + a * xv + b * yv;
      const double du = u - right_x_[i], dv = v - right_y_[i];
      addCandidate(du * du + dv * dv, i);
      const double density = std::max(
          1 / right_area_, density_.others(u, v, right_x_[i], right_y_[i]) / static_cast<double>(n - 1));
      for (std::size_t t = 0; t < kThresholds; ++t)
        chance[t] += std::min(1.0, density * kPi * kThreshold[t] * kThreshold[t]);
    }
    for (double& share : chance) share /= static_cast<double>(trials);
    countDistinct();
    const Significance found =
        judge(trials, 0, std::log10(static_cast<double>(kThresholds * kLeastTests)), chance);
    if (half == 0 || found.confidence < worst.confidence) worst = found;
  }
  return worst;
}

double confidenceOf(const Correspondences& matches, const Selection& selection, std::uint64_t hypotheses) {
  if (std::none_of(selection.mask.begin(), selection.mask.end(), [](std::uint8_t m) { return m != 0; }))
    return 0;
  SignificanceTest& test = WorkspaceScope::part<SignificanceTest>();
  test.assign(matches);
  switch (selection.model_kind) {
    case ModelKind::kHomography:
      return test.homography(selection.model, hypotheses).confidence;
    case ModelKind::kFundamental:
      return test.fundamental(selection.model, hypotheses).confidence;
    case ModelKind::kNone:
      break;
  }
  return test.local(selection.mask).confidence;
}

}  // namespace corrsel::core
