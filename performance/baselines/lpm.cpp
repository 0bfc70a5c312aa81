#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nanoflann.hpp>
#include <numeric>

#include "baselines.h"

namespace corrsel::baselines {
namespace {

/// Left x, y, right x, y.
using Match = std::array<double, 4>;

/// Points of one image for nanoflann: columns `side` and `side + 1` of the matches that take part.
struct Points {
  const std::vector<Match>& matches;
  const std::vector<std::size_t>& members;
  std::size_t side;
  std::size_t kdtree_get_point_count() const { return members.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return matches[members[i]][side + axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 2>;

/// The k nearest by (distance, number). nanoflann's own result set leaves it to the tree which of several
/// points at the largest distance are kept.
class NearestByDistanceAndNumber {
 public:
  using DistanceType = double;
  using IndexType = std::size_t;
  explicit NearestByDistanceAndNumber(std::size_t k) : k_(k) {}
  bool full() const { return true; }
  bool empty() const { return found_.empty(); }
  void sort() {}  // they are always sorted
  bool addPoint(double distance, std::size_t number) {
    const std::pair<double, std::size_t> entry(distance, number);
    found_.insert(std::upper_bound(found_.begin(), found_.end(), entry), entry);
    if (found_.size() > k_) found_.pop_back();
    // nanoflann offers what is strictly nearer: one step up lets equal distances in.
    if (found_.size() == k_) worst_ = std::nextafter(found_.back().first, kInfinity);
    return true;
  }
  double worstDist() const { return worst_; }
  const std::vector<std::pair<double, std::size_t>>& found() const { return found_; }
  void clear() {
    found_.clear();
    worst_ = kInfinity;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::size_t k_;
  double worst_ = kInfinity;
  std::vector<std::pair<double, std::size_t>> found_;
};

struct Rule {
  bool motion;  // v2: three scales, common neighbours must also move alike
  double lambda_first, lambda_second;
  std::vector<std::pair<int, int>> windows;  // first neighbour and number of neighbours
  int listed;                                // neighbours needed for all windows
};
constexpr double kTau = 0.2, kNoiseFloor = 7, kSlack = 1e-6;

Rule ruleOf(LpmVariant variant) {
  // The published v2 code loses one more of the nearest neighbours at each scale.
  if (variant == LpmVariant::kV2) return {true, 0.8, 0.5, {{0, 8}, {1, 6}, {2, 4}}, 8};
  return {false, 6, 6, {{0, 4}}, 4};
}

bool disagree(const Match& a, const Match& b) {
  const double ax = a[2] - a[0], ay = a[3] - a[1], bx = b[2] - b[0], by = b[3] - b[1];
  const double aa = ax * ax + ay * ay, bb = bx * bx + by * by;
  if ((ax - bx) * (ax - bx) + (ay - by) * (ay - by) <= kNoiseFloor * kNoiseFloor) return false;
  if (aa == 0 || bb == 0) return true;
  return (ax * bx + ay * by) / std::sqrt(aa * bb) * std::min(aa, bb) / std::max(aa, bb) < kTau;
}

/// Cost of every match against neighbourhoods among the members, as in the published code: the nearest point
/// found is dropped as the match itself.
std::vector<double> costs(const std::vector<Match>& matches, const std::vector<std::size_t>& members,
                          const Rule& rule) {
  const Points left_points{matches, members, 0}, right_points{matches, members, 2};
  Tree left_tree(2, left_points), right_tree(2, right_points);
#if NANOFLANN_VERSION < 0x140  // later versions build the tree in its constructor
  left_tree.buildIndex();
  right_tree.buildIndex();
#endif
  NearestByDistanceAndNumber left(std::size_t(rule.listed) + 1), right(left);
  std::vector<double> result(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    left.clear();
    right.clear();
    left_tree.findNeighbors(left, &matches[i][0], {});
    right_tree.findNeighbors(right, &matches[i][2], {});
    double sum = 0;
    for (const auto& [begin, length] : rule.windows) {
      int common = 0, disagreeing = 0;
      for (int a = begin + 1; a <= begin + length; ++a) {
        for (int b = begin + 1; b <= begin + length; ++b) {
          const std::size_t neighbour = left.found()[std::size_t(a)].second;
          if (neighbour != right.found()[std::size_t(b)].second) continue;
          ++common;
          if (rule.motion && disagree(matches[i], matches[members[neighbour]])) ++disagreeing;
        }
      }
      sum += rule.motion ? double(length - common + disagreeing) / length : 2.0 * (length - common);
    }
    result[i] = sum / double(rule.windows.size());
  }
  return result;
}

std::vector<std::size_t> within(const std::vector<double>& cost, double lambda) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < cost.size(); ++i) {
    if (cost[i] <= lambda + kSlack) rows.push_back(i);
  }
  return rows;
}

}  // namespace

Mask lpmTextbook(const core::Correspondences& m, LpmVariant variant) {
  std::vector<Match> input(m.size());
  for (std::size_t i = 0; i < m.size(); ++i)
    input[i] = {m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]};
  // Distinct matches in the order of their coordinates.
  std::vector<Match> distinct = input;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());

  Mask mask(m.size(), 0);
  const Rule rule = ruleOf(variant);
  const std::size_t needed = std::size_t(rule.listed) + 2;
  if (distinct.size() < needed) return mask;
  std::vector<std::size_t> members(distinct.size());
  std::iota(members.begin(), members.end(), std::size_t{0});
  members = within(costs(distinct, members, rule), rule.lambda_first);
  if (members.size() >= needed) members = within(costs(distinct, members, rule), rule.lambda_second);
  Mask accepted(distinct.size(), 0);
  for (const std::size_t row : members) accepted[row] = 1;
  for (std::size_t i = 0; i < m.size(); ++i) {
    const auto found = std::lower_bound(distinct.begin(), distinct.end(), input[i]);
    mask[i] = accepted[std::size_t(found - distinct.begin())];
  }
  return mask;
}

}  // namespace corrsel::baselines
