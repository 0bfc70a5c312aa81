#include "corrsel/reference/rfm_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/coordinate_order.h"
#include "reference/cluster_numbers.h"
#include "selectors/parts/degenerate_input.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 6;
constexpr std::size_t kRandom = 20;      // matches that are formed of two others
constexpr std::size_t kSampled = 512;    // matches among which the loneliest one is found
constexpr std::size_t kFirst = 64;       // matches whose L is computed first
constexpr float kOutside = 100;          // factor of the distances to matches in no cluster
constexpr float kMinSide = 1.0F / 2000;  // of a cell
constexpr float kRounding = 1.0001F;     // bounds are larger by this than the distances require
constexpr std::uint32_t kNone = ClusterNumbers::kNone;

/// A match in units of the ranges of its columns: left x and y, right x and y, motion in x and y.
using Point = std::array<float, 6>;

/// The distance D with a largest value of interest.
class Distance {
 public:
  Distance(double gamma, float limit) : gamma_(static_cast<float>(gamma)), limit_(limit) {
    largest_motion_ = kRounding * limit / (1 + gamma_ * std::exp(-limit / 2));
  }

  Distance within(float limit) const { return {gamma_, limit}; }

  float limit() const { return limit_; }

  /// The largest d3 within the limit: min(d1, d2) is at most half of it.
  float largestMotion() const { return largest_motion_; }

  static float squared(float x, float y) { return x * x + y * y; }

  float operator()(const Point& a, const Point& b) const {
    const float left = std::sqrt(squared(a[0] - b[0], a[1] - b[1]));
    const float right = std::sqrt(squared(a[2] - b[2], a[3] - b[3]));
    const float motion = std::sqrt(squared(a[4] - b[4], a[5] - b[5]));
    return left + right + (1 + gamma_ * std::exp(-std::min(left, right))) * motion;
  }

  /// False only where D is above the limit.
  bool canBeWithin(const Point& a, const Point& b) const {
    const bool motion = squared(a[4] - b[4], a[5] - b[5]) <= largest_motion_ * largest_motion_;
    const bool points =
        squared(a[0] - b[0], a[1] - b[1]) + squared(a[2] - b[2], a[3] - b[3]) <= limit_ * limit_ * kRounding;
    return motion & points;
  }

  /// Whether D times a factor is within the limit.
  bool isWithin(const Point& a, const Point& b, float factor) const {
    if (factor > 1 && factor * factor * squared(a[4] - b[4], a[5] - b[5]) > largest_motion_ * largest_motion_)
      return false;
    return factor * (*this)(a, b) <= limit_;
  }

 private:
  float gamma_, limit_, largest_motion_;
};

/// Matches in the cells of a four-dimensional grid of left points and motions.
class Cells {
 public:
  using Range = std::pair<std::uint32_t, std::uint32_t>;  // first, and one past the last

  /// Sorts points into cells, so that those within the limit of a point are in neighbouring cells.
  /// @param factor  of the distances to every point
  void build(const std::vector<Point>& points, const std::vector<float>& factor, const Distance& distance) {
    const float left = 1 / std::max(distance.limit() * kRounding, kMinSide);
    const float motion = 1 / std::max(distance.largestMotion(), kMinSide);
    entries_.resize(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      entries_[i] = {index(p[4] * motion) << 48 | index(p[5] * motion) << 32 | index(p[0] * left) << 16 |
                         index(p[1] * left),
                     i};
    }
    std::sort(entries_.begin(), entries_.end());
    keys_.clear();
    begin_.clear();
    points_.clear();
    factor_.clear();
    for (const auto& [key, number] : entries_) {
      if (keys_.empty() || keys_.back() != key) {
        keys_.push_back(key);
        begin_.push_back(static_cast<std::uint32_t>(points_.size()));
      }
      points_.push_back(points[number]);
      factor_.push_back(factor[number]);
    }
    begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
    findNeighbours();
  }

  std::size_t count() const { return keys_.size(); }

  /// The points of a cell, as places in the order of the cells.
  Range places(std::size_t cell) const { return {begin_[cell], begin_[cell + 1]}; }

  /// The places of cells that follow each other.
  Range places(Range cells) const { return {begin_[cells.first], begin_[cells.second]}; }

  /// The point at a place, the factor of the distances to it, and its number.
  const Point& point(std::size_t place) const { return points_[place]; }
  float factor(std::size_t place) const { return factor_[place]; }
  std::uint32_t numberAt(std::size_t place) const { return entries_[place].second; }

  /// Ranges of the cells next to a cell; the first one contains the cell itself.
  const Range* firstRange(std::size_t cell) const { return ranges_.data() + first_range_[cell]; }
  const Range* lastRange(std::size_t cell) const { return ranges_.data() + first_range_[cell + 1]; }

  /// Calls visit(place) for the places near a cell whose points can be within the limit of a point, until it
  /// returns true. @return whether it did
  template <class Visit>
  bool visitNear(std::size_t cell, const Point& point, const Distance& distance, const Visit& visit) const {
    for (const Range* range = firstRange(cell); range != lastRange(cell); ++range) {
      const auto [begin, end] = places(*range);
      for (std::uint32_t block = begin; block < end; block += kBlock) {
        // Without branches, because half of them would be mispredicted.
        std::array<std::uint32_t, kBlock> near;
        std::size_t found = 0;
        for (std::uint32_t place = block; place < std::min(end, block + kBlock); ++place) {
          near[found] = place;
          found += distance.canBeWithin(point, points_[place]) ? 1 : 0;
        }
        for (std::size_t k = 0; k < found; ++k) {
          if (visit(near[k])) return true;
        }
      }
    }
    return false;
  }

 private:
  static constexpr std::size_t kRows = 27;  // neighbours in all dimensions but the last
  static constexpr std::uint32_t kBlock = 64;

  /// @param place  0 to 2000
  static std::uint64_t index(float place) { return static_cast<std::uint64_t>(place) + 1; }

  void findNeighbours() {
    std::array<std::int64_t, kRows> step{};
    std::array<std::uint32_t, kRows> next{};
    std::size_t rows = 1;  // the first one is the cell's own
    for (std::int64_t a = -1; a <= 1; ++a) {
      for (std::int64_t b = -1; b <= 1; ++b) {
        for (std::int64_t c = -1; c <= 1; ++c) {
          if (a != 0 || b != 0 || c != 0) step[rows++] = a * (1LL << 48) + b * (1LL << 32) + c * (1LL << 16);
        }
      }
    }
    ranges_.clear();
    first_range_.clear();
    // Cells are visited in the order of their keys, so that each of the neighbouring rows is passed once.
    for (const std::uint64_t key : keys_) {
      first_range_.push_back(ranges_.size());
      for (std::size_t row = 0; row < kRows; ++row) {
        const std::uint64_t centre = key + static_cast<std::uint64_t>(step[row]);
        std::uint32_t first = next[row];
        while (first < keys_.size() && keys_[first] < centre - 1) ++first;
        next[row] = first;
        std::uint32_t last = first;
        while (last < keys_.size() && keys_[last] <= centre + 1) ++last;
        if (last > first) ranges_.emplace_back(first, last);
      }
    }
    first_range_.push_back(ranges_.size());
  }

  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries_;  // key and number of the points, sorted
  std::vector<std::uint64_t> keys_;                               // of the cells
  std::vector<std::uint32_t> begin_;                              // first place of the cells
  std::vector<Point> points_;                                     // by place
  std::vector<float> factor_;
  std::vector<Range> ranges_;
  std::vector<std::size_t> first_range_;
};

/// DBSCAN, see the header of the class RfmScanSelector.
class Clusters {
 public:
  /// @param cells   built for the distance
  /// @param min_members  points within the limit that make a core
  void find(const Cells& cells, const Distance& distance, std::size_t min_members) {
    findCores(cells, distance, min_members);
    joinCores(cells, distance);
    findMembers(cells, distance);
  }

  /// The cluster of every point, a number below that of the points, or kNone.
  const std::vector<std::uint32_t>& of() const { return of_; }

 private:
  using Range = Cells::Range;

  void findCores(const Cells& cells, const Distance& distance, std::size_t min_members) {
    cores_.clear();
    cores_before_.clear();
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
      const auto [begin, end] = cells.places(cell);
      for (std::uint32_t place = begin; place < end; ++place) {
        cores_before_.push_back(static_cast<std::uint32_t>(cores_.size()));
        if (isCore(cells, cell, place, distance, min_members)) cores_.push_back(place);
      }
    }
    cores_before_.push_back(static_cast<std::uint32_t>(cores_.size()));
  }

  static bool isCore(const Cells& cells, std::size_t cell, std::uint32_t place, const Distance& distance,
                     std::size_t min_members) {
    const Point point = cells.point(place);
    std::size_t within = 0;
    return cells.visitNear(cell, point, distance, [&](std::uint32_t other) {
      return distance.isWithin(point, cells.point(other), cells.factor(other)) && ++within >= min_members;
    });
  }

  Range coresIn(Range places) const { return {cores_before_[places.first], cores_before_[places.second]}; }

  std::uint32_t rootOf(std::uint32_t core) {
    while (parent_[core] != core) core = parent_[core] = parent_[parent_[core]];
    return core;
  }

  /// Joins the clusters of two cores within the limit. @return whether they were different ones
  bool joinIfNear(const Cells& cells, std::uint32_t a, std::uint32_t b, const Distance& distance) {
    const std::uint32_t root_a = rootOf(a), root_b = rootOf(b);
    if (root_a == root_b) return false;
    const std::uint32_t place_a = cores_[a], place_b = cores_[b];
    const Point &point_a = cells.point(place_a), &point_b = cells.point(place_b);
    if (!distance.canBeWithin(point_a, point_b) ||
        !distance.isWithin(point_a, point_b, std::min(cells.factor(place_a), cells.factor(place_b))))
      return false;
    parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
    return true;
  }

  /// Whether all cores of a range are in one cluster. @pre there are any
  bool areJoined(Range cores) {
    for (std::uint32_t core = cores.first + 1; core < cores.second; ++core) {
      if (rootOf(core) != rootOf(cores.first)) return false;
    }
    return true;
  }

  /// Joins cores within the limit. Pairs of cells whose cores are in one cluster already are left out, so
  /// that dense cells cost no more than sparse ones.
  void joinCores(const Cells& cells, const Distance& distance) {
    parent_.resize(cores_.size());
    std::iota(parent_.begin(), parent_.end(), 0U);
    is_joined_.assign(cells.count(), 0);
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
      const Range own = coresIn(cells.places(cell));
      if (own.first == own.second) continue;
      std::size_t clusters = 0;
      for (std::uint32_t a = own.first; a < own.second; ++a) {
        ++clusters;
        for (std::uint32_t b = a; b > own.first && clusters > 1; --b)
          clusters -= joinIfNear(cells, a, b - 1, distance) ? 1 : 0;
      }
      is_joined_[cell] = clusters == 1 ? 1 : 0;
    }
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
      const Range own = coresIn(cells.places(cell));
      if (own.first == own.second) continue;
      for (const Range* range = cells.firstRange(cell); range != cells.lastRange(cell); ++range) {
        for (std::size_t other = range->first; other < std::min<std::size_t>(range->second, cell); ++other)
          joinCells(cells, cell, other, distance);
      }
      is_joined_[cell] = areJoined(own) ? 1 : 0;
    }
  }

  void joinCells(const Cells& cells, std::size_t cell, std::size_t other, const Distance& distance) {
    const Range own = coresIn(cells.places(cell)), others = coresIn(cells.places(other));
    if (others.first == others.second) return;
    const bool are_joined = is_joined_[cell] != 0 && is_joined_[other] != 0;
    for (std::uint32_t a = own.first; a < own.second; ++a) {
      for (std::uint32_t b = others.first; b < others.second; ++b) {
        if (are_joined && rootOf(a) == rootOf(b)) return;
        joinIfNear(cells, a, b, distance);
      }
    }
  }

  /// Cores are in the cluster of their root, the others in that of the nearest core.
  void findMembers(const Cells& cells, const Distance& distance) {
    of_.assign(cores_before_.size() - 1, kNone);
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
      const auto [begin, end] = cells.places(cell);
      for (std::uint32_t place = begin; place < end; ++place) {
        std::uint32_t core = cores_before_[place];
        if (cores_before_[place + 1] == core) core = nearestCore(cells, cell, place, distance);
        if (core != kNone) of_[cells.numberAt(place)] = rootOf(core);
      }
    }
  }

  std::uint32_t nearestCore(const Cells& cells, std::size_t cell, std::uint32_t place,
                            const Distance& distance) const {
    const Point point = cells.point(place);
    const float factor = cells.factor(place);
    const Distance scaled = distance.within(distance.limit() / factor);
    std::uint32_t nearest = kNone;
    float smallest = std::numeric_limits<float>::infinity();
    for (const Range* range = cells.firstRange(cell); range != cells.lastRange(cell); ++range) {
      const auto [begin, end] = coresIn(cells.places(*range));
      for (std::uint32_t core = begin; core < end; ++core) {
        const Point& other = cells.point(cores_[core]);
        if (!scaled.canBeWithin(point, other) || !distance.isWithin(point, other, factor)) continue;
        const float d = distance(point, other);
        if (d < smallest ||
            (d == smallest && cells.numberAt(cores_[core]) < cells.numberAt(cores_[nearest]))) {
          smallest = d;
          nearest = core;
        }
      }
    }
    return nearest;
  }

  std::vector<std::uint32_t> cores_, cores_before_;  // places; number of cores before every place
  std::vector<std::uint32_t> parent_;                // by core
  std::vector<std::uint8_t> is_joined_;              // whether all cores of a cell are in one cluster
  std::vector<std::uint32_t> of_;
};

/// Memory that is kept between calls.
struct RfmScanMemory {
  std::vector<KeyedRow> rows, scratch;
  std::vector<Point> points;  // in the order of the coordinates
  std::vector<Point> outliers;
  std::vector<float> factor, distances;
  Cells cells;
  Clusters clusters;
  std::vector<std::uint32_t> sizes;
  ClusterNumbers numbers;
};

/// Forms outliers, and divides all columns by their ranges.
void scale(const Correspondences& matches, RfmScanMemory& work) {
  const std::size_t n = work.rows.size();
  const auto point = [&](std::size_t left, std::size_t right) {
    const std::uint32_t l = work.rows[left].row, r = work.rows[right].row;
    return Point{matches.left_x[l],
                 matches.left_y[l],
                 matches.right_x[r],
                 matches.right_y[r],
                 matches.right_x[r] - matches.left_x[l],
                 matches.right_y[r] - matches.left_y[l]};
  };
  work.points.clear();
  for (std::size_t i = 0; i < n; ++i) work.points.push_back(point(i, i));
  work.outliers.clear();
  for (std::size_t k = 0; k < kRandom; ++k)
    work.outliers.push_back(point(k * n / kRandom, (k * n / kRandom + n / 2) % n));
  for (std::size_t column = 0; column < 6; ++column) {
    float low = work.points[0][column], high = low;
    for (const std::vector<Point>* points : {&work.points, &work.outliers}) {
      for (const Point& p : *points) {
        low = std::min(low, p[column]);
        high = std::max(high, p[column]);
      }
    }
    const float range = high > low ? high - low : 1;
    for (std::vector<Point>* points : {&work.points, &work.outliers}) {
      for (Point& p : *points) p[column] = (p[column] - low) / range;
    }
  }
}

/// The k-th smallest value, from 1. Changes the order of the values.
float smallest(std::size_t k, std::vector<float>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(k - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The distance of a point from the match that is the `min_members`-th nearest one.
float reachOf(const Point& point, const Distance& distance, std::size_t min_members, RfmScanMemory& work) {
  work.distances.clear();
  for (std::size_t i = 0; i < work.points.size(); ++i)
    work.distances.push_back(work.factor[i] * distance(point, work.points[i]));
  return smallest(min_members, work.distances);
}

/// Whether `min_members` matches are within the limit of a point. Looks at match `start` first.
bool isReached(const Point& point, std::size_t start, const Distance& distance, std::size_t min_members,
               const RfmScanMemory& work) {
  std::size_t within = 0;
  const std::size_t n = work.points.size();
  for (std::size_t k = 0, i = start; k < n; ++k, i = i + 1 < n ? i + 1 : 0) {
    if (distance.canBeWithin(point, work.points[i]) &&
        distance.isWithin(point, work.points[i], work.factor[i]) && ++within >= min_members)
      return true;
  }
  return false;
}

/// The smallest distance of a match from the `min_members`-th nearest one.
/// @param bound  the same for a few matches
float minReach(Distance bound, std::size_t min_members, RfmScanMemory& work) {
  const Cells& cells = work.cells;
  work.cells.build(work.points, work.factor, bound);
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    const auto [begin, end] = cells.places(cell);
    for (std::uint32_t place = begin; place < end; ++place) {
      const Point point = cells.point(place);
      work.distances.clear();
      cells.visitNear(cell, point, bound, [&](std::uint32_t other) {
        if (bound.isWithin(point, cells.point(other), cells.factor(other)))
          work.distances.push_back(cells.factor(other) * bound(point, cells.point(other)));
        return false;
      });
      if (work.distances.size() >= min_members) bound = bound.within(smallest(min_members, work.distances));
    }
  }
  return bound.limit();
}

/// The radius of the clusters.
float radius(double gamma, double share, std::size_t min_members, RfmScanMemory& work) {
  const std::size_t n = work.points.size(), first = std::min(n, kFirst), sampled = std::min(n, kSampled);
  const Distance start(gamma, 0);
  Distance min_reach = start.within(reachOf(work.points[0], start, min_members, work)), max_reach = min_reach;
  for (std::size_t k = 1; k < first; ++k) {
    const std::size_t i = k * n / first;
    if (isReached(work.points[i], i, min_reach, min_members, work))
      min_reach = start.within(reachOf(work.points[i], start, min_members, work));
  }
  const float low = minReach(min_reach, min_members, work);
  const auto compare = [&](const Point& point, std::size_t i) {
    if (!isReached(point, i, max_reach, min_members, work))
      max_reach = start.within(reachOf(point, start, min_members, work));
  };
  for (std::size_t k = 0; k < sampled; ++k) compare(work.points[k * n / sampled], k * n / sampled);
  for (const Point& point : work.outliers) compare(point, 0);
  return low + static_cast<float>(share) * (max_reach.limit() - low);
}

}  // namespace

void RfmScanOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"gamma", 0, 1000, "-", "Weight of the motion for matches that are near each other"},
                 &RfmScanOptions::gamma);
  visitor.number({"min_points_share", 0, 1, "-",
                  "Share of the matches that must be near a match of a cluster, itself included"},
                 &RfmScanOptions::min_points_share);
  visitor.integer({"min_points", 1, 1000, "-", "Smallest number of such matches"},
                  &RfmScanOptions::min_points);
  visitor.integer({"max_points", 1, 1000, "-", "Largest number of such matches"},
                  &RfmScanOptions::max_points);
  visitor.number({"first_epsilon", 0, 1, "-",
                  "First round: radius of clusters, 0 = that of the densest match, 1 = of the loneliest one"},
                 &RfmScanOptions::first_epsilon);
  visitor.number({"second_epsilon", 0, 1, "-", "Second round: radius of clusters"},
                 &RfmScanOptions::second_epsilon);
  visitConfidence(visitor);
}

void RfmScanOptions::check() const {
  ConfidenceOptions::check();
  if (min_points > max_points) {
    throw std::invalid_argument("option min_points = " + std::to_string(min_points) +
                                " is above max_points = " + std::to_string(max_points));
  }
}

void RfmScanSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  if (n < kMinMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, rfm_scan needs " + std::to_string(kMinMatches);
    return;
  }
  if (endsAtEqualPoints(matches, result)) return;
  RfmScanMemory& work = workspace.part<RfmScanMemory>();
  sortByCoordinates(matches, work.rows, work.scratch);
  scale(matches, work);
  const auto share = static_cast<int>(std::lround(options_.min_points_share * static_cast<double>(n)));
  const std::size_t min_members =
      std::min(n, static_cast<std::size_t>(std::clamp(share, options_.min_points, options_.max_points)));
  work.factor.assign(n, 1);
  for (const double epsilon : {options_.first_epsilon, options_.second_epsilon}) {
    const float limit = radius(options_.gamma, epsilon, min_members, work);
    const Distance distance(options_.gamma, limit);
    work.cells.build(work.points, work.factor, distance);
    work.clusters.find(work.cells, distance, min_members);
    ++result.iterations;
    bool any = false;
    for (std::size_t i = 0; i < n; ++i) {
      const bool inside = work.clusters.of()[i] != kNone;
      work.factor[i] = inside ? 1 : kOutside;
      any = any || inside;
    }
    if (!any) break;
  }
  work.sizes.assign(n, 0);
  for (const std::uint32_t cluster : work.clusters.of()) {
    if (cluster != kNone) ++work.sizes[cluster];
  }
  work.numbers.assign(work.clusters.of(), work.sizes);
  result.score.assign(n, 0);
  if (work.numbers.count() == 0) {
    result.message = "no cluster";
    return;
  }
  result.group.assign(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t cluster = work.clusters.of()[i], row = work.rows[i].row;
    if (cluster == kNone) continue;
    result.mask[row] = 1;
    result.group[row] = work.numbers[cluster];
    result.score[row] = static_cast<float>(work.sizes[cluster]);
  }
}

}  // namespace corrsel::core
