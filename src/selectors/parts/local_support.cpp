#include "selectors/parts/local_support.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace corrsel::core {
namespace {

constexpr float kFloor = 3;              // px: least tolerance
constexpr double kRho[2] = {0.12, 0.3};  // relative tolerances
constexpr double kLocalRho = 0.3, kExtendedRho = 0.45;
constexpr double kReach = 1.0 / 8;  // of the diagonal: relative tolerances grow up to this distance
constexpr double kRarest = 0.02;    // least number of supporters expected by chance
constexpr double kTests = SupportRule::kRadii + SupportRule::kCoarseRadii;  // per hypothesis
constexpr double kCaution = 4;        // survivors expected by chance: e^-4
constexpr double kCostOfPartner = 1;  // S of a map from two matches is lowered by this
constexpr int kVoters = 8;            // survivors that decide about the local set
constexpr float kLeastLeft = 8, kLeastRight = 3, kMostScale = 6;  // of two matches that give a similarity

/// The number of matches that hypotheses are made for.
std::size_t budget(std::size_t n, bool frames) {
  const std::size_t most =
      frames ? std::max<std::size_t>(100, 1000000 / n) : std::max<std::size_t>(60, 800000 / n);
  return std::min(n, most);
}

/// Area that the first quadrant of the unit disc shares with [0, width] x [0, height].
double quadrantArea(double width, double height) {
  width = std::min(width, 1.0);
  height = std::min(height, 1.0);
  if (width * width + height * height <= 1) return width * height;
  const auto below_circle = [](double x) { return (x * std::sqrt(1 - x * x) + std::asin(x)) / 2; };
  const double corner = std::sqrt(1 - height * height);
  return height * corner + below_circle(width) - below_circle(corner);
}

/// k ln(k / lambda) - (k - lambda), 0 where k is no more than chance.
double logRatio(double k, double lambda) {
  return k > lambda ? k * std::log(k / lambda) - (k - lambda) : 0.0;
}

/// What a local map predicts of a displacement, and how far the actual one is from it, squared.
struct Prediction {
  float uu, ee;
  Prediction(const LinearMap& a, float dx, float dy, float vx, float vy) {
    const float ux = a[0] * dx + a[1] * dy, uy = a[2] * dx + a[3] * dy;
    const float ex = vx - ux, ey = vy - uy;
    uu = ux * ux + uy * uy;
    ee = ex * ex + ey * ey;
  }
  /// Whether the error is at most rho |u|, with |u| at most `reach`, or 3 px.
  bool within(double rho, double reach) const {
    const double length = std::min<double>(uu, reach * reach);
    return ee <= std::max<double>(kFloor * kFloor, rho * rho * length);
  }
};

/// The similarity that takes a left displacement to a right one.
LinearMap similarity(float dx, float dy, float vx, float vy) {
  const float squared = dx * dx + dy * dy;
  const float a = (vx * dx + vy * dy) / squared, b = (vy * dx - vx * dy) / squared;
  return {a, -b, b, a};
}

/// The bounds of the first n values, widened by the least tolerance.
std::array<double, 2> boundsOf(const std::vector<float>& values, std::size_t n) {
  const auto [low, high] =
      std::minmax_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n));
  return {*low - double{kFloor}, *high + double{kFloor}};
}

}  // namespace

void LocalSupport::compute(const Correspondences& matches, const std::vector<std::uint32_t>& order,
                           int threads) {
  layOut(matches, order);
  support_.assign(n_, 0);
  maps_.assign(n_, LinearMap{});
  local_.assign(n_, 0);
  extended_.assign(n_, 0);
  survivors_.clear();
  local_size_ = 0;
  if (n_ == 0) return;

  const bool frames = !matches.left_frame.empty() && !matches.right_frame.empty();
  const std::size_t judged = budget(n_, frames);
  const int wanted = frames ? 1 : kMostPartners;
  significant_support_ = std::log(kTests * static_cast<double>(n_) * wanted) + kCaution;
  best_.assign(judged, 0);
  best_map_.assign(judged, LinearMap{});
  sortPool(judged);
  constexpr std::size_t kBlock = 16;  // matches that a thread judges at a time
  forEachBlock(judged, kBlock, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Place place = placeOf(i);
      LinearMap map;
      if (frames && frameMap(matches, i, map)) judge(i, map, nullptr, place);
      std::uint32_t found[kMostPartners];
      const int count = partners(i, wanted, found);
      for (int p = 0; p < count; ++p) {
        const std::uint32_t j = found[p];
        judge(i,
              similarity(left_x_[j] - left_x_[i], left_y_[j] - left_y_[i], right_x_[j] - right_x_[i],
                         right_y_[j] - right_y_[i]),
              &j, place);
      }
    }
  });
  for (std::size_t i = 0; i < judged; ++i) {
    support_[row_[i]] = best_[i];
    if (best_[i] > 0) maps_[row_[i]] = best_map_[i];
  }
  findLocalSets();
}

void LocalSupport::layOut(const Correspondences& m, const std::vector<std::uint32_t>& order) {
  n_ = order.size();
  const std::size_t padded =
      (n_ + VotingMatches::kMultiple - 1) / VotingMatches::kMultiple * VotingMatches::kMultiple;
  row_ = order;
  rank_.resize(n_);
  for (std::size_t i = 0; i < n_; ++i) rank_[row_[i]] = static_cast<std::uint32_t>(i);
  for (std::vector<float>* const column : {&left_x_, &left_y_, &right_x_, &right_y_})
    column->assign(padded, 0);
  for (std::size_t i = 0; i < n_; ++i) {
    left_x_[i] = m.left_x[row_[i]];
    left_y_[i] = m.left_y[row_[i]];
    right_x_[i] = m.right_x[row_[i]];
    right_y_[i] = m.right_y[row_[i]];
  }
  weight_.assign(padded, 0);
  if (n_ == 0) return;
  findWeights();
  bounds_x_ = boundsOf(right_x_, n_);
  bounds_y_ = boundsOf(right_y_, n_);
  diagonal_ = std::hypot(bounds_x_[1] - bounds_x_[0], bounds_y_[1] - bounds_y_[0]);
  if (m.right_size.area() > 0) {
    diagonal_ = std::hypot(m.right_size.width, m.right_size.height);
    bounds_x_ = {std::max(bounds_x_[0], 0.0), std::min<double>(bounds_x_[1], m.right_size.width)};
    bounds_y_ = {std::max(bounds_y_[0], 0.0), std::min<double>(bounds_y_[1], m.right_size.height)};
  }
  for (int r = 0; r < SupportRule::kRadii; ++r) {
    const double radius = diagonal_ / (16 >> r);
    rule_.squared_radius[r] = static_cast<float>(radius * radius);
  }
  for (int t = 0; t < 2; ++t) rule_.squared_rho[t] = static_cast<float>(kRho[t] * kRho[t]);
  rule_.squared_floor = kFloor * kFloor;
}

void LocalSupport::findWeights() {
  cells_.resize(n_);
  const auto sortBy = [this](const std::vector<float>& values) {
    for (KeyedRow& cell : cells_) cell.key = sortKey(std::round(values[cell.row]));
    radixSort(cells_, scratch_);
  };
  for (std::size_t i = 0; i < n_; ++i) cells_[i].row = static_cast<std::uint32_t>(i);
  sortBy(right_x_);
  sortBy(right_y_);
  weights_.resize(n_);
  std::int64_t all = 0;
  const auto samePlace = [this](std::uint32_t a, std::uint32_t b) {
    return std::round(right_x_[a]) == std::round(right_x_[b]) &&
           std::round(right_y_[a]) == std::round(right_y_[b]);
  };
  for (std::size_t begin = 0, end = 0; begin < n_; begin = end) {
    while (end < n_ && samePlace(cells_[begin].row, cells_[end].row)) ++end;
    const auto count = static_cast<std::int32_t>(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      weight_[cells_[i].row] = std::max(1, VotingMatches::kOne / count);
      weights_[row_[cells_[i].row]] = 1.0F / static_cast<float>(count);
      all += weight_[cells_[i].row];
    }
  }
  all_weights_ = static_cast<double>(all) / VotingMatches::kOne;
}

bool LocalSupport::frameMap(const Correspondences& m, std::size_t rank, LinearMap& map) const {
  constexpr double kMostArea = double{kMostScale} * kMostScale, kMostStretch = 32;
  const AffineFrame &left = m.left_frame[row_[rank]], &right = m.right_frame[row_[rank]];
  const double a = left[0], b = left[1], c = left[3], d = left[4], det = a * d - b * c;
  double norm = 0;
  for (std::size_t row = 0; row < 2; ++row) {
    const double p = right[3 * row], q = right[3 * row + 1];
    const double first = (p * d - q * c) / det, second = (q * a - p * b) / det;
    map[2 * row] = static_cast<float>(first);
    map[2 * row + 1] = static_cast<float>(second);
    norm += first * first + second * second;
  }
  const double area = std::abs((right[0] * double{right[4]} - right[1] * double{right[3]}) / det);
  // Comparisons with NaN are false.
  return area >= 1 / kMostArea && area <= kMostArea && norm <= kMostStretch * area;
}

void LocalSupport::sortPool(std::size_t judged) {
  pool_.resize(std::min(n_, std::max({std::size_t{300}, n_ / 4, judged})));
  for (std::size_t i = 0; i < pool_.size(); ++i)
    pool_[i] = {sortKey(left_x_[i]), static_cast<std::uint32_t>(i)};
  radixSort(pool_, scratch_);
  in_pool_.resize(pool_.size());
  for (std::size_t i = 0; i < pool_.size(); ++i) in_pool_[pool_[i].row] = static_cast<std::uint32_t>(i);
}

int LocalSupport::partners(std::size_t rank, int wanted, std::uint32_t* out) const {
  float distances[kMostPartners];
  int found = 0;
  const float x = left_x_[rank], y = left_y_[rank], u = right_x_[rank], v = right_y_[rank];
  /// @return false where no match further along x can be nearer than those found
  const auto visit = [&](std::uint32_t j) {
    const float dx = left_x_[j] - x, dy = left_y_[j] - y;
    if (found == wanted && dx * dx > distances[found - 1]) return false;
    const float left = dx * dx + dy * dy;
    const auto isNearer = [&](int place) {
      return left < distances[place] || (left == distances[place] && j < out[place]);
    };
    if (left < kLeastLeft * kLeastLeft || (found == wanted && !isNearer(found - 1))) return true;
    const float vx = right_x_[j] - u, vy = right_y_[j] - v;
    const float right = vx * vx + vy * vy;
    if (right < kLeastRight * kLeastRight || right > kMostScale * kMostScale * left ||
        left > kMostScale * kMostScale * right) {
      return true;
    }
    int place = found < wanted ? found++ : found - 1;
    for (; place > 0 && isNearer(place - 1); --place) {
      distances[place] = distances[place - 1];
      out[place] = out[place - 1];
    }
    distances[place] = left;
    out[place] = j;
    return true;
  };
  const std::size_t start = in_pool_[rank];
  bool before = true, behind = true;
  for (std::size_t step = 1; before || behind; ++step) {
    before = before && step <= start && visit(pool_[start - step].row);
    behind = behind && start + step < pool_.size() && visit(pool_[start + step].row);
  }
  return found;
}

LocalSupport::Place LocalSupport::placeOf(std::size_t rank) const {
  Place place;
  kernels().support.around(columns(), right_x_[rank], right_y_[rank], rule_, place.right);
  return place;
}

double LocalSupport::visibleShare(std::size_t rank, int radius, Place& place) const {
  double& share = place.visible[radius];
  if (share == 0) {
    const double r = diagonal_ / (16 >> radius), x = right_x_[rank], y = right_y_[rank];
    const double left = std::max(0.0, x - bounds_x_[0]) / r, right = std::max(0.0, bounds_x_[1] - x) / r;
    const double above = std::max(0.0, y - bounds_y_[0]) / r, below = std::max(0.0, bounds_y_[1] - y) / r;
    const double area = quadrantArea(left, above) + quadrantArea(left, below) + quadrantArea(right, above) +
                        quadrantArea(right, below);
    share = std::max(area / CV_PI, 1e-3);
  }
  return share;
}

void LocalSupport::judge(std::size_t rank, const LinearMap& map, const std::uint32_t* partner, Place& place) {
  constexpr double kUnit = 1.0 / VotingMatches::kOne;
  SupportCounts counts;
  kernels().support.count(
      columns(),
      {map[0], map[1], map[2], map[3], left_x_[rank], left_y_[rank], right_x_[rank], right_y_[rank]}, rule_,
      counts);
  if (partner != nullptr) {
    // The map was made to fit the partner, which therefore is no supporter.
    const std::uint32_t j = *partner;
    const float vx = right_x_[j] - right_x_[rank], vy = right_y_[j] - right_y_[rank];
    for (int r = 0; r < SupportRule::kRadii; ++r) {
      if (vx * vx + vy * vy > rule_.squared_radius[r]) continue;
      counts.fine[r] = std::max<std::int64_t>(0, counts.fine[r] - weight_[j]);
      if (r < SupportRule::kCoarseRadii)
        counts.coarse[r] = std::max<std::int64_t>(0, counts.coarse[r] - weight_[j]);
    }
  }
  const double cost = partner != nullptr ? kCostOfPartner : 0;
  double best = best_[rank] + cost;
  const auto test = [&](int r, int t, std::int64_t supporters) {
    const double k = static_cast<double>(supporters) * kUnit;
    const double share =
        std::max<double>(rule_.squared_rho[t] / 2, rule_.squared_floor / rule_.squared_radius[r]);
    const double in_both =
        static_cast<double>(counts.left[r]) * kUnit * static_cast<double>(place.right[r]) * kUnit;
    const double expected = in_both / all_weights_ * share;
    // The share of the disc that is visible only lowers the ratio, and is not needed where that is too low.
    if (logRatio(k, expected + kRarest) <= best) return;
    const double ratio = logRatio(k, expected / visibleShare(rank, r, place) + kRarest);
    if (ratio <= best) return;
    best = ratio;
    best_[rank] = static_cast<float>(ratio - cost);
    best_map_[rank] = map;
  };
  for (int r = 0; r < SupportRule::kRadii; ++r) test(r, 0, counts.fine[r]);
  for (int r = 0; r < SupportRule::kCoarseRadii; ++r) test(r, 1, counts.coarse[r]);
}

void LocalSupport::findLocalSets() {
  const double reach = kReach * diagonal_;
  members_.clear();
  for (std::size_t i = 0; i < best_.size(); ++i) {
    if (best_[i] > significant_support_) members_.push_back(static_cast<std::uint32_t>(i));
  }
  if (members_.empty()) return;
  const int k = static_cast<int>(std::min<std::size_t>(members_.size(), kVoters + 1));
  const auto stride = static_cast<std::size_t>(k);
  near_.resize(n_ * stride);
  neighbours_.build(left_x_.data(), left_y_.data(), members_.size(), k, members_.data());
  neighbours_.nearestToAll(left_x_.data(), left_y_.data(), n_, k, near_.data());
  for (std::size_t j = 0; j < n_; ++j) {
    int voters = 0, for_local = 0, for_extended = 0;
    for (std::size_t place = 0; place < stride && voters < kVoters; ++place) {
      const std::uint32_t i = near_[j * stride + place];
      if (i == j) continue;
      const Prediction prediction(best_map_[i], left_x_[j] - left_x_[i], left_y_[j] - left_y_[i],
                                  right_x_[j] - right_x_[i], right_y_[j] - right_y_[i]);
      ++voters;
      for_local += prediction.within(kLocalRho, reach) ? 1 : 0;
      for_extended += prediction.within(kExtendedRho, reach) ? 1 : 0;
    }
    const std::uint32_t row = row_[j];
    local_[row] = 2 * for_local > kVoters ? 1 : 0;
    extended_[row] = 2 * for_extended > kVoters ? 1 : 0;
    local_size_ += local_[row];
  }
  std::stable_sort(members_.begin(), members_.end(),
                   [this](std::uint32_t a, std::uint32_t b) { return best_[a] > best_[b]; });
  for (const std::uint32_t i : members_) survivors_.push_back(row_[i]);
}

void LocalSupport::supporters(std::uint32_t row, double radius, double rho,
                              std::vector<std::uint32_t>& rows) const {
  rows.clear();
  const std::uint32_t i = rank_[row];
  const LinearMap& map = maps_[row];
  const auto most = static_cast<float>(radius * radius);
  for (std::size_t j = 0; j < n_; ++j) {
    const Prediction prediction(map, left_x_[j] - left_x_[i], left_y_[j] - left_y_[i],
                                right_x_[j] - right_x_[i], right_y_[j] - right_y_[i]);
    if (prediction.uu <= most && prediction.within(rho, radius)) rows.push_back(row_[j]);
  }
}

VotingMatches LocalSupport::columns() const {
  return {left_x_.data(), left_y_.data(), right_x_.data(), right_y_.data(), weight_.data(), weight_.size()};
}

}  // namespace corrsel::core
