#include "search/local_support.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.h"

namespace corrsel::core {
namespace {

constexpr float kFloor = 3;              // px: min tolerance
constexpr double kRho[2] = {0.12, 0.3};  // relative tolerances
constexpr double kLocalRho = 0.3, kExtendedRho = 0.45;
constexpr double kReach = 1.0 / 8;  // of the diagonal: relative tolerances grow up to this distance
constexpr double kRarest = 0.02;    // min number of supporters expected by chance
constexpr double kTests = 6;        // per hypothesis: radii and tolerances
constexpr double kCaution = 4;      // survivors expected by chance: e^-4
// Larger discs are looked at only where the smaller ones leave it open whether the map is right.
constexpr double kSure = 2;      // S, in units of what is significant
constexpr double kHopeless = 2;  // S where the smaller discs hold enough matches:
constexpr double kEnough = 40;
constexpr double kCostOfPartner = 1;  // S of a map from two matches is lowered by this
constexpr std::uint32_t kNone = 0xffffffffU;
constexpr int kVoters = 8;                                   // survivors that decide about the local set
constexpr float kMinLeft = 8, kMinRight = 3, kMaxScale = 6;  // of two matches that give a similarity

/// The number of matches that hypotheses are made for: up to `max_hypotheses`, fewer where many survive.
struct Budget {
  static constexpr std::size_t kBatch = 64;       // matches verified before the survivors are counted again
  static constexpr std::size_t kSurvivors = 200;  // more hypotheses are not needed
  // Where many of those verified survive, fewer are enough.
  static constexpr std::size_t kSurvivorsWhereEasy = 64;
  static constexpr double kEasy = 0.3;
  static constexpr double kApart = 0.25;  // of `max_hypotheses`: matches outside of the local set, afterwards

  std::size_t max_hypotheses;

  Budget(std::size_t n, bool frames)
      : max_hypotheses(std::min(
            n, frames ? std::max<std::size_t>(100, 1000000 / n) : std::max<std::size_t>(60, 800000 / n))) {}

  /// The end of the batch that begins with match `start`; `start` itself where no more matches are verified.
  std::size_t batchEnd(std::size_t start, std::size_t survivors) const {
    const bool easy = survivors >= kSurvivorsWhereEasy &&
                      static_cast<double>(survivors) >= kEasy * static_cast<double>(start);
    return easy || survivors >= kSurvivors ? start : std::min(max_hypotheses, start + kBatch);
  }
};

/// The area of a huge image would overflow.
bool isKnown(const cv::Size& image) { return image.width > 0 && image.height > 0; }

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

/// Writes the runs of whole multiples of slots, one per row of cells, that hold all points of a box.
/// @return their number
std::size_t findRuns(const PointCells& cells, double x, double y, double half_width, double half_height,
                     SupportRun* runs) {
  constexpr std::uint32_t kMask = SupportRun::kMultiple - 1;
  std::size_t found = 0;
  cells.visitRuns(x, y, half_width, half_height, [&](std::uint32_t begin, std::uint32_t end) {
    begin &= ~kMask;
    end = (end + kMask) & ~kMask;
    if (begin < end) runs[found++] = {begin, end};
  });
  return found;
}

/// The similarity that takes a left displacement to a right one.
LinearMap similarity(float dx, float dy, float vx, float vy) {
  const float squared = dx * dx + dy * dy;
  const float a = (vx * dx + vy * dy) / squared, b = (vy * dx - vx * dy) / squared;
  return {a, -b, b, a};
}

float squaredLength(float x, float y) { return x * x + y * y; }

}  // namespace

bool LocalSupport::compute(const Correspondences& matches, const std::vector<std::uint32_t>& order,
                           int threads, const Deadline& deadline) {
  n_ = order.size();
  row_ = order;
  support_.assign(n_, 0);
  weights_.assign(n_, 1);
  maps_.assign(n_, LinearMap{});
  local_.assign(n_, 0);
  extended_.assign(n_, 0);
  survivors_.clear();
  local_size_ = 0;
  if (n_ == 0) return true;
  layOut(matches);

  const bool frames = !matches.left_frame.empty() && !matches.right_frame.empty();
  const Budget budget(n_, frames);
  significant_support_ = std::log(kTests * static_cast<double>(n_) * partnersPerMatch(frames)) + kCaution;
  best_.assign(n_, 0);
  best_map_.assign(n_, LinearMap{});
  members_.clear();
  sortPool(budget.max_hypotheses);
  candidates_.resize(budget.max_hypotheses);
  std::iota(candidates_.begin(), candidates_.end(), 0U);
  std::size_t verified = 0;
  bool cut = false;
  for (std::size_t end = 0; !cut && (end = budget.batchEnd(verified, members_.size())) > verified;
       verified = end) {
    verifyBatch(matches, frames, verified, end, threads);
    cut = deadline.passed();
  }
  extendLocalSets();
  // Small groups that move by themselves have few of the best matches, or none. They stand out among those
  // that the survivors do not predict.
  const auto apart = static_cast<std::size_t>(Budget::kApart * static_cast<double>(budget.max_hypotheses));
  candidates_.clear();
  for (std::size_t i = verified; !cut && i < n_ && candidates_.size() < apart; ++i) {
    if (extended_[row_[i]] == 0) candidates_.push_back(static_cast<std::uint32_t>(i));
  }
  const std::size_t before = members_.size();
  verifyBatch(matches, frames, 0, candidates_.size(), threads);
  // Fewer have no majority of their own.
  if (2 * (members_.size() - before) > kVoters) extendLocalSets();
  std::sort(members_.begin(), members_.end(), [this](std::uint32_t a, std::uint32_t b) {
    return best_[a] != best_[b] ? best_[a] > best_[b] : a < b;
  });
  for (const std::uint32_t i : members_) survivors_.push_back(row_[i]);
  local_size_ = static_cast<std::size_t>(std::count(local_.begin(), local_.end(), 1));
  return !cut;
}

void LocalSupport::verifyBatch(const Correspondences& matches, bool frames, std::size_t first,
                               std::size_t last, int threads) {
  constexpr std::size_t kBlock = 16;  // matches that a thread verifies at a time
  const int wanted = partnersPerMatch(frames);
  forEachBlock(last - first, kBlock, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t place = first + begin; place < first + end; ++place) {
      const std::uint32_t i = candidates_[place];
      Place of_map;
      LinearMap map;
      if (frames && frameMap(matches, i, map)) verify(i, map, nullptr, of_map);
      std::uint32_t found[kMaxPartners];
      const int count = partners(i, wanted, found);
      // The farthest one first: its map is the most precise.
      for (int p = count - 1; p >= 0 && best_[i] <= kSure * significant_support_; --p) {
        const std::uint32_t j = found[p];
        verify(i,
               similarity(left_x_[j] - left_x_[i], left_y_[j] - left_y_[i], right_x_[j] - right_x_[i],
                          right_y_[j] - right_y_[i]),
               &j, of_map);
      }
    }
  });
  for (std::size_t place = first; place < last; ++place) {
    const std::uint32_t i = candidates_[place];
    support_[row_[i]] = best_[i];
    maps_[row_[i]] = best_map_[i];
    if (best_[i] > significant_support_) members_.push_back(i);
  }
}

LocalSupport::Bounds LocalSupport::boundsOf(const std::vector<float>& x, const std::vector<float>& y,
                                            const cv::Size& image) {
  Bounds bounds;
  const std::vector<float>* const columns[] = {&x, &y};
  const int sizes[] = {image.width, image.height};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto [low, high] = std::minmax_element(columns[axis]->begin(), columns[axis]->end());
    bounds.low[axis] = *low - double{kFloor};
    bounds.high[axis] = *high + double{kFloor};
    if (isKnown(image)) {
      bounds.low[axis] = std::max(bounds.low[axis], 0.0);
      bounds.high[axis] = std::min<double>(bounds.high[axis], sizes[axis]);
    }
  }
  return bounds;
}

CellGrid LocalSupport::gridOver(const Bounds& bounds) const {
  // By measurement: rows of about 16 sqrt(n / 256) points.
  const int side = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(n_)) / 4), 1, kMaxRows);
  CellGrid grid{bounds.low[0], bounds.low[1], 0, 0, side, side};
  grid.cell_width = std::max(bounds.high[0] - bounds.low[0], 1e-6) / side;
  grid.cell_height = std::max(bounds.high[1] - bounds.low[1], 1e-6) / side;
  return grid;
}

void LocalSupport::layOut(const Correspondences& m) {
  left_x_.resize(n_);
  left_y_.resize(n_);
  right_x_.resize(n_);
  right_y_.resize(n_);
  for (std::size_t i = 0; i < n_; ++i) {
    left_x_[i] = m.left_x[row_[i]];
    left_y_[i] = m.left_y[row_[i]];
    right_x_[i] = m.right_x[row_[i]];
    right_y_[i] = m.right_y[row_[i]];
  }
  findWeights();
  const Bounds left = boundsOf(left_x_, left_y_, m.left_size);
  bounds_ = boundsOf(right_x_, right_y_, m.right_size);
  const bool sized = isKnown(m.right_size);
  const double width = sized ? m.right_size.width : bounds_.high[0] - bounds_.low[0];
  const double height = sized ? m.right_size.height : bounds_.high[1] - bounds_.low[1];
  diagonal_ = std::hypot(width, height);
  area_ = std::max(1.0, width * height);
  constexpr std::uint32_t kMultiple = SupportRun::kMultiple;
  left_cells_.build(left_x_.data(), left_y_.data(), n_, gridOver(left), kMultiple);
  right_cells_.build(right_x_.data(), right_y_.data(), n_, gridOver(bounds_), kMultiple);
  by_left_.assign(left_cells_);
  by_right_.assign(right_cells_);
  for (std::size_t i = 0; i < n_; ++i) {
    for (Columns* const columns : {&by_left_, &by_right_}) {
      const std::uint32_t slot = (columns == &by_left_ ? left_cells_ : right_cells_).slotOf()[i];
      columns->left_x[slot] = left_x_[i];
      columns->left_y[slot] = left_y_[i];
      columns->right_x[slot] = right_x_[i];
      columns->right_y[slot] = right_y_[i];
      columns->weight[slot] = weight_[i];
    }
  }
}

void LocalSupport::findWeights() {
  unit_ = std::max(1, static_cast<std::int32_t>(std::min<std::size_t>(4096, (std::size_t{1} << 30) / n_)));
  right_points_.number(right_x_, right_y_, 1);
  weight_.resize(n_);
  std::int64_t all = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    const std::uint32_t count = right_points_.sizes[right_points_.of[i]];
    weight_[i] = std::max(1, unit_ / static_cast<std::int32_t>(count));
    weights_[row_[i]] = 1.0F / static_cast<float>(count);
    all += weight_[i];
  }
  all_weights_ = static_cast<double>(all) / unit_;
}

bool LocalSupport::frameMap(const Correspondences& m, std::size_t rank, LinearMap& map) const {
  constexpr double kMaxArea = double{kMaxScale} * kMaxScale, kMaxStretch = 32;
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
  return area >= 1 / kMaxArea && area <= kMaxArea && norm <= kMaxStretch * area;
}

void LocalSupport::sortPool(std::size_t verified) {
  pool_.resize(std::min(n_, std::max({std::size_t{300}, n_ / 4, verified})));
  for (std::size_t i = 0; i < pool_.size(); ++i)
    pool_[i] = {sortKey(left_x_[i]), static_cast<std::uint32_t>(i)};
  radixSort(pool_, scratch_);
  pool_left_x_.resize(pool_.size());
  pool_left_y_.resize(pool_.size());
  pool_right_x_.resize(pool_.size());
  pool_right_y_.resize(pool_.size());
  for (std::size_t i = 0; i < pool_.size(); ++i) {
    const std::uint32_t rank = pool_[i].row;
    pool_left_x_[i] = left_x_[rank];
    pool_left_y_[i] = left_y_[rank];
    pool_right_x_[i] = right_x_[rank];
    pool_right_y_[i] = right_y_[rank];
  }
}

int LocalSupport::partners(std::size_t rank, int wanted, std::uint32_t* out) const {
  float distances[kMaxPartners];
  int found = 0;
  const float x = left_x_[rank], y = left_y_[rank], u = right_x_[rank], v = right_y_[rank];
  /// @return false where no match further along x can be nearer than those found
  const auto visit = [&](std::size_t slot) {
    const float dx = pool_left_x_[slot] - x, dy = pool_left_y_[slot] - y;
    if (found == wanted && dx * dx > distances[found - 1]) return false;
    const float left = dx * dx + dy * dy;
    if (left < kMinLeft * kMinLeft || (found == wanted && left > distances[found - 1])) return true;
    const std::uint32_t j = pool_[slot].row;
    const auto isNearer = [&](int place) {
      return left < distances[place] || (left == distances[place] && j < out[place]);
    };
    if (found == wanted && !isNearer(found - 1)) return true;
    const float vx = pool_right_x_[slot] - u, vy = pool_right_y_[slot] - v;
    const float right = vx * vx + vy * vy;
    if (right < kMinRight * kMinRight || right > kMaxScale * kMaxScale * left ||
        left > kMaxScale * kMaxScale * right) {
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
  const auto place = std::lower_bound(pool_.begin(), pool_.end(), sortKey(x),
                                      [](const KeyedRow& row, std::uint32_t key) { return row.key < key; });
  const auto start = static_cast<std::size_t>(place - pool_.begin());
  bool before = true, behind = true;
  for (std::size_t step = 0; before || behind; ++step) {
    before = before && step < start && visit(start - 1 - step);
    behind = behind && start + step < pool_.size() && visit(start + step);
  }
  return found;
}

double LocalSupport::visibleShare(std::size_t rank, int disc, Place& place) const {
  double& share = place.visible[disc];
  if (share == 0) {
    const double r = radius(disc), x = right_x_[rank], y = right_y_[rank];
    const double left = std::max(0.0, x - bounds_.low[0]) / r, right = std::max(0.0, bounds_.high[0] - x) / r;
    const double above = std::max(0.0, y - bounds_.low[1]) / r,
                 below = std::max(0.0, bounds_.high[1] - y) / r;
    const double area = quadrantArea(left, above) + quadrantArea(left, below) + quadrantArea(right, above) +
                        quadrantArea(right, below);
    share = std::max(area / CV_PI, 1e-3);
  }
  return share;
}

/// What makes a match a supporter, in the smallest two discs at once or in a larger one.
SupportRule LocalSupport::ruleOf(int disc) const {
  const bool near = disc < SupportRule::kRadii;
  SupportRule rule{};
  rule.squared_floor = kFloor * kFloor;
  for (int t = 0; t < SupportRule::kTolerances; ++t)
    rule.squared_rho[t] = static_cast<float>(kRho[t] * kRho[t]);
  for (int i = 0; i < SupportRule::kRadii; ++i)
    rule.squared_radius[i] = static_cast<float>(radius(near ? i : disc) * radius(near ? i : disc));
  return rule;
}

void LocalSupport::verify(std::size_t rank, const LinearMap& map, const std::uint32_t* partner,
                          Place& place) {
  constexpr int kNear = SupportRule::kRadii;
  const float x = left_x_[rank], y = left_y_[rank], u = right_x_[rank], v = right_y_[rank];
  const double unit = unit_, cost = partner != nullptr ? kCostOfPartner : 0;
  float to_partner = 0;
  if (partner != nullptr) to_partner = squaredLength(right_x_[*partner] - u, right_y_[*partner] - v);
  // Half the size of the box around the points that the map takes into the unit disc.
  const double det = std::abs(double{map[0]} * map[3] - double{map[1]} * map[2]);
  const double width = std::hypot(map[1], map[3]) / det, height = std::hypot(map[0], map[2]) / det;
  constexpr double kMargin = 1.0001;  // for the rounding errors of single precision
  const SupportKernels& kernel = kernels().support;
  SupportRun runs[kMaxRows];
  double best = 0, in_disc = 0;  // S so far, and the matches in the largest disc so far

  for (int disc = kNear - 1; disc < kDiscs; ++disc) {
    const bool near = disc < kNear;
    const double r = radius(disc) * kMargin;
    const SupportRule rule = ruleOf(disc);
    SupportCounts counts;
    std::size_t found = findRuns(left_cells_, x, y, r * width, r * height, runs);
    (near ? kernel.both : kernel.first)(by_left_.view(), runs, found,
                                        {map[0], map[1], map[2], map[3], x, y, u, v}, rule, counts);
    if (place.right[disc] < 0) {
      found = findRuns(right_cells_, u, v, r, r, runs);
      (near ? kernel.around_both : kernel.around_first)(by_right_.view(), runs, found, u, v, rule,
                                                        place.right + (near ? 0 : disc));
    }
    for (int i = 0; i < (near ? kNear : 1); ++i) {
      const int of_place = near ? i : disc;
      const double left = counts.left[i] / unit, right = place.right[of_place] / unit;
      for (int t = 0; t < (near ? SupportRule::kTolerances : 1); ++t) {
        std::int32_t supporters = counts.supporters[i][t];
        // The map was made to fit the partner, which therefore is no supporter.
        if (partner != nullptr && to_partner <= rule.squared_radius[i] && to_partner > rule.squared_floor)
          supporters = std::max(0, supporters - weight_[*partner]);
        const double k = supporters / unit;
        const double share =
            std::max<double>(rule.squared_rho[t] / 2, rule.squared_floor / rule.squared_radius[i]);
        const double expected = left * right / all_weights_ * share;
        // That a part of the disc is invisible only lowers the ratio.
        if (logRatio(k, expected + kRarest) <= best) continue;
        best = std::max(best, logRatio(k, expected / visibleShare(rank, of_place, place) + kRarest));
      }
      in_disc = left;
    }
    if (best > kSure * significant_support_ || (best < kHopeless && in_disc >= kEnough)) break;
  }
  best -= cost;
  if (best > best_[rank]) {
    best_[rank] = static_cast<float>(best);
    best_map_[rank] = map;
  }
}

void LocalSupport::extendLocalSets() {
  const double reach = kReach * diagonal_;
  if (2 * members_.size() <= kVoters) return;
  const int k = static_cast<int>(std::min<std::size_t>(members_.size(), kVoters + 1));
  const auto stride = static_cast<std::size_t>(k);
  open_.clear();
  for (std::uint32_t j = 0; j < n_; ++j)
    if (local_[row_[j]] == 0 || extended_[row_[j]] == 0) open_.push_back(j);
  near_.resize(open_.size() * stride);
  neighbours_.build(left_x_.data(), left_y_.data(), members_.size(), k, members_.data());
  neighbours_.nearestToAll(left_x_.data(), left_y_.data(), open_.size(), k, near_.data(), open_.data());
  for (std::size_t query = 0; query < open_.size(); ++query) {
    const std::uint32_t j = open_[query];
    int voters = 0, for_local = 0, for_extended = 0;
    std::uint32_t nearest = kNone;  // of the survivors that predict this match
    // Until the rest cannot change the result: agreement for the local set is agreement for the extended one,
    // too.
    const auto isOpen = [&] {
      return 2 * for_local <= kVoters && 2 * (for_extended + kVoters - voters) > kVoters;
    };
    for (std::size_t place = 0; place < stride && voters < kVoters && isOpen(); ++place) {
      const std::uint32_t i = near_[query * stride + place];
      if (i == j) continue;
      const Prediction prediction(best_map_[i], left_x_[j] - left_x_[i], left_y_[j] - left_y_[i],
                                  right_x_[j] - right_x_[i], right_y_[j] - right_y_[i]);
      ++voters;
      for_local += prediction.within(kLocalRho, reach) ? 1 : 0;
      if (!prediction.within(kExtendedRho, reach)) continue;
      ++for_extended;
      if (nearest == kNone) nearest = i;
    }
    const std::uint32_t row = row_[j];
    if (2 * for_local > kVoters) local_[row] = 1;
    if (2 * for_extended <= kVoters || extended_[row] != 0) continue;
    extended_[row] = 1;
    if (best_[j] <= significant_support_) maps_[row] = best_map_[nearest];
  }
}

void LocalSupport::Columns::assign(const PointCells& cells) {
  for (std::vector<float>* const column : {&left_x, &left_y, &right_x, &right_y})
    column->assign(cells.slots(), 0);
  weight.assign(cells.slots(), 0);
}

VotingMatches LocalSupport::Columns::view() const {
  return {left_x.data(), left_y.data(), right_x.data(), right_y.data(), weight.data()};
}

}  // namespace corrsel::core
