#include "corrsel/reference/logos.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "corrsel/neighbours.h"
#include "geometry/frame_map.h"
#include "points/distinct_matches.h"
#include "points/point_groups.h"
#include "selectors/parts/degenerate_input.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kBinsPerDifference = 3;
constexpr double kSamePixel = 1;  // px

/// The similarity part of the map between the frames of a match.
struct Turn {
  double cosine, sine, angle, log_scale, squared_scale;
};

Turn turnOf(double a, double b, double c, double d) {
  const double cosine = a + d, sine = c - b, length = std::hypot(cosine, sine);
  const double squared_scale = std::abs(a * d - b * c);
  if (length == 0) return {1, 0, 0, std::log(squared_scale) / 2, squared_scale};
  return {cosine / length, sine / length, std::atan2(sine, cosine), std::log(squared_scale) / 2,
          squared_scale};
}

/// Memory that is kept between calls.
struct LogosMemory {
  std::vector<LinearMap> maps;
  std::vector<std::uint32_t> rows;  // matches with a map
  DistinctMatches distinct;
  PlanarNeighbours index;
  std::vector<float> right_x, right_y;     // of the distinct matches
  PointGroups right_points;                // of the distinct matches
  std::vector<float> point_x, point_y;     // of the distinct right points
  std::vector<std::uint32_t> left, right;  // neighbours of every match, and of every right point
  std::vector<Turn> turns;
  std::vector<std::uint32_t> stamp, supports, histogram;
  std::vector<std::uint8_t> selected;
};

/// What two matches are compared with.
struct Limits {
  double difference, cosine, growth;  // cos and exp(2 ..) of the difference
};

bool support(const PairColumns& m, std::size_t i, std::size_t j, const std::vector<Turn>& turns,
             const Limits& limits) {
  const Turn &a = turns[i], &b = turns[j];
  if (!(std::abs(a.log_scale - b.log_scale) < limits.difference)) return false;
  if (!(a.cosine * b.cosine + a.sine * b.sine > limits.cosine)) return false;
  const double ux = double{m.left_x[j]} - m.left_x[i], uy = double{m.left_y[j]} - m.left_y[i];
  const double vx = double{m.right_x[j]} - m.right_x[i], vy = double{m.right_y[j]} - m.right_y[i];
  const double uu = ux * ux + uy * uy, vv = vx * vx + vy * vy, grown = uu * a.squared_scale;
  if (uu == 0 || vv == 0 || !(vv < grown * limits.growth && vv * limits.growth > grown)) return false;
  const double along = (a.cosine * ux - a.sine * uy) * vx + (a.sine * ux + a.cosine * uy) * vy;
  return along > limits.cosine * std::sqrt(uu * vv);
}

/// Counts the supports of every match.
void findSupports(int k, const Limits& limits, LogosMemory& work) {
  const std::size_t n = work.distinct.size();
  work.supports.assign(n, 0);
  if (n < 2) return;
  const PairColumns m = work.distinct.columns();
  const auto with_itself = static_cast<std::size_t>(k) + 1;
  const std::size_t left_length = std::min(with_itself, n);
  work.left.resize(n * left_length);
  // With x and y exchanged, the order of the cells is that of the matches, see PairGraph.
  work.index.build(m.left_y, m.left_x, n, static_cast<int>(left_length));
  work.index.nearestToAll(m.left_y, m.left_x, n, static_cast<int>(left_length), work.left.data());
  // Many outliers can share a right point, which is one neighbour all the same.
  work.right_x.assign(m.right_x, m.right_x + n);
  work.right_y.assign(m.right_y, m.right_y + n);
  work.right_points.number(work.right_x, work.right_y, kSamePixel);
  const std::vector<std::uint32_t>& point_of = work.right_points.of;
  const std::size_t points = work.right_points.sizes.size();
  work.point_x.resize(points);
  work.point_y.resize(points);
  for (std::size_t i = n; i-- > 0;) {
    work.point_x[point_of[i]] = work.right_x[i];
    work.point_y[point_of[i]] = work.right_y[i];
  }
  const std::size_t right_length = std::min(with_itself, points);
  work.right.resize(points * right_length);
  work.index.build(work.point_y.data(), work.point_x.data(), points, static_cast<int>(right_length));
  work.index.nearestToAll(work.point_y.data(), work.point_x.data(), points, static_cast<int>(right_length),
                          work.right.data());
  work.stamp.assign(points, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const auto stamp = static_cast<std::uint32_t>(i + 1);
    const std::uint32_t* const near = work.right.data() + point_of[i] * right_length;
    for (std::size_t e = 0; e < right_length; ++e) work.stamp[near[e]] = stamp;
    for (std::size_t e = 0; e < left_length; ++e) {
      const std::uint32_t j = work.left[i * left_length + e];
      if (j != i && work.stamp[point_of[j]] == stamp && support(m, i, j, work.turns, limits))
        ++work.supports[i];
    }
  }
}

/// The most frequent rotation of the matches that have support.
double modeOfRotations(double difference, LogosMemory& work) {
  const auto bins =
      static_cast<std::size_t>(std::max(3.0, std::ceil(2 * kPi * kBinsPerDifference / difference)));
  work.histogram.assign(bins, 0);
  const double per_radian = static_cast<double>(bins) / (2 * kPi);
  for (std::size_t i = 0; i < work.turns.size(); ++i) {
    if (work.supports[i] == 0) continue;
    const double place = (work.turns[i].angle + kPi) * per_radian;
    work.histogram[std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, place)))] +=
        static_cast<std::uint32_t>(work.distinct.multiplicity(i));
  }
  std::size_t best = 0, largest = 0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const std::size_t sum = std::size_t{work.histogram[(bin + bins - 1) % bins]} + work.histogram[bin] +
                            work.histogram[(bin + 1) % bins];
    if (sum > largest) {
      largest = sum;
      best = bin;
    }
  }
  // The mean within the three bins.
  const double centre = (static_cast<double>(best) + 0.5) / per_radian - kPi;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < work.turns.size(); ++i) {
    const double apart = std::remainder(work.turns[i].angle - centre, 2 * kPi);
    if (work.supports[i] == 0 || std::abs(apart) > 1.5 / per_radian) continue;
    sum += apart * static_cast<double>(work.distinct.multiplicity(i));
    count += static_cast<double>(work.distinct.multiplicity(i));
  }
  return count > 0 ? centre + sum / count : centre;
}

}  // namespace

void LogosOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"k", 1, PointGrid::kMaxNeighbours - 1, "-", "Neighbours in each image"}, &LogosOptions::k);
  visitor.number({"max_difference", 0.01, 3, "rad",
                  "Largest difference of rotations, and of natural logarithms of scales"},
                 &LogosOptions::max_difference);
  visitor.flag("global", "Keep only matches whose rotation is near the most frequent one",
               &LogosOptions::global);
  visitConfidence(visitor);
}

Presets LogosSelector::presets() const { return {{"opencv", {{"k", "5"}, {"max_difference", "0.1"}}}}; }

std::string LogosSelector::missingInput(const Correspondences& matches) const {
  return missingFrames(matches, "logos");
}

void LogosSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  LogosMemory& work = workspace.part<LogosMemory>();
  findFrameMaps(matches, work.maps, work.rows);
  if (endsAtFrames(matches, work.rows.size(), result)) return;
  work.distinct.assign(matches, work.maps, work.rows);
  const PairColumns m = work.distinct.columns();
  work.turns.clear();
  for (std::size_t i = 0; i < work.distinct.size(); ++i)
    work.turns.push_back(turnOf(m.a11[i], m.a12[i], m.a21[i], m.a22[i]));
  const double difference = options_.max_difference;
  findSupports(options_.k, {difference, std::cos(difference), std::exp(2 * difference)}, work);
  const double mode = options_.global ? modeOfRotations(difference, work) : 0;
  work.selected.resize(work.distinct.size());
  for (std::size_t i = 0; i < work.distinct.size(); ++i) {
    const double apart = std::abs(std::remainder(work.turns[i].angle - mode, 2 * kPi));
    work.selected[i] = work.supports[i] > 0 && (!options_.global || apart < difference) ? 1 : 0;
  }
  result.iterations = 1;
  result.score.assign(n, std::numeric_limits<float>::quiet_NaN());
  for (const std::uint32_t row : work.rows) {
    const std::uint32_t i = work.distinct.ofRow(row);
    result.score[row] = static_cast<float>(work.supports[i]);
    result.mask[row] = work.selected[i];
  }
}

}  // namespace corrsel::core
