#include "corrsel/selectors/lpm.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/coordinate_order.h"
#include "base/workspace_scope.h"
#include "corrsel/selectors/neighbours.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

/// A window [begin, begin + length) of the neighbour list that forms one neighbourhood.
struct Window {
  int begin, length;
};

/// Neighbourhoods, and how many neighbours they need to be listed.
struct Layout {
  Window windows[3] = {};
  int count = 1, listed = 0;
};

Layout layoutOf(const LpmOptions& options) {
  Layout layout;
  if (options.cost == LpmOptions::Cost::kCount) {
    layout.windows[0] = {0, options.k};
  } else {
    // The authors' code slices its table again at every scale and so loses one more of the nearest each time.
    const int step = options.compat ? 1 : 0;
    layout.count = 3;
    for (int i = 0; i < 3; ++i) layout.windows[i] = {i * step, options.k + 2 - 2 * i};
  }
  for (const Window& window : layout.windows)
    layout.listed = std::max(layout.listed, window.begin + window.length);
  return layout;
}

/// Motion of a match, px, and its squared length.
struct Motion {
  double x, y, squared;
};

/// Distinct matches and the memory that a call needs, which is kept between calls. Matches are numbered in
/// the order of their coordinates: ties broken by number then do not depend on the order of the input.
struct LpmMemory {
  std::vector<float> left_x, left_y, right_x, right_y;
  std::vector<std::uint32_t> of_input;  // per input match: its distinct match
  std::vector<Motion> motions;
  std::vector<KeyedRow> rows, scratch;

  PlanarNeighbours left, right;
  std::vector<std::uint32_t> near_left, near_right;  // lists of neighbours
  std::vector<std::uint64_t> common;                 // see NeighbourKernels
  std::vector<float> cost;
  std::vector<std::uint32_t> accepted;
  std::vector<std::uint8_t> mask;

  std::size_t size() const { return left_x.size(); }
};

void findDistinct(const Correspondences& matches, bool merge, LpmMemory& work) {
  const std::size_t n = matches.size();
  sortByCoordinates(matches, work.rows, work.scratch);
  std::vector<float>* const columns[] = {&work.left_x, &work.left_y, &work.right_x, &work.right_y};
  for (std::vector<float>* const column : columns) column->resize(n);
  work.of_input.resize(n);
  std::uint32_t distinct = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t row = work.rows[i].row;
    const bool repeated = merge && i > 0 && work.rows[i].key == work.rows[i - 1].key &&
                          compareCoordinates(matches, work.rows[i - 1].row, row) == 0;
    if (!repeated) {
      work.left_x[distinct] = matches.left_x[row];
      work.left_y[distinct] = matches.left_y[row];
      work.right_x[distinct] = matches.right_x[row];
      work.right_y[distinct] = matches.right_y[row];
      ++distinct;
    }
    work.of_input[row] = distinct - 1;
  }
  for (std::vector<float>* const column : columns) column->resize(distinct);
}

void findMotions(LpmMemory& work) {
  work.motions.resize(work.size());
  for (std::size_t i = 0; i < work.size(); ++i) {
    const double x = static_cast<double>(work.right_x[i]) - work.left_x[i];
    const double y = static_cast<double>(work.right_y[i]) - work.left_y[i];
    work.motions[i] = {x, y, x * x + y * y};
  }
}

/// When two motions agree, see the class documentation.
struct MotionRule {
  double tau, squared_floor;
};

bool disagree(const Motion& a, const Motion& b, const MotionRule& rule) {
  const double tau = rule.tau, dx = a.x - b.x, dy = a.y - b.y;
  if (dx * dx + dy * dy <= rule.squared_floor) return false;
  const double dot = a.x * b.x + a.y * b.y;
  const double shorter = std::min(a.squared, b.squared), longer = std::max(a.squared, b.squared);
  // Squaring both sides of the comparison avoids a division and a root. The result is the same unless both
  // sides are equal but for rounding; then the comparison below decides.
  if (tau > 0 && dot > 0) {
    const double agreement = dot * dot * shorter, needed = tau * tau * longer * longer * longer;
    if (agreement > needed * 1.000001) return false;
    if (agreement < needed * 0.999999) return true;
  }
  if (shorter == 0) return (longer == 0 ? 1.0 : 0.0) < tau;
  return dot / std::sqrt(a.squared * b.squared) * shorter / longer < tau;
}

/// Moves every list so that its neighbours, the match itself taken out, stand at 1 .. listed.
void takeOutSelf(std::vector<std::uint32_t>& lists, std::size_t count, std::size_t length) {
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t* const list = lists.data() + i * length;
    std::uint32_t* const end = std::find(list, list + length - 1, static_cast<std::uint32_t>(i));
    std::move_backward(list, end, end + 1);
  }
}

/// Neighbour lists of all matches in both images: lists of 1 + layout.listed, the first of which is not used.
void findNeighbours(const std::vector<std::uint32_t>* members, const Layout& layout, bool compat,
                    LpmMemory& work) {
  const std::size_t n = work.size(), length = static_cast<std::size_t>(layout.listed) + 1;
  const std::size_t count = members != nullptr ? members->size() : n;
  const std::uint32_t* const numbers = members != nullptr ? members->data() : nullptr;
  constexpr std::size_t kBeyond = 8;  // numbers that the comparison may read behind the end
  work.near_left.resize(n * length + kBeyond);
  work.near_right.resize(n * length + kBeyond);
  // Matches are numbered by x, cells along their first coordinate. With x and y exchanged both orders agree,
  // which keeps what is used together in the processor's cache.
  const int k = layout.listed + 1;
  work.left.build(work.left_y.data(), work.left_x.data(), count, k, numbers);
  work.left.nearestToAll(work.left_y.data(), work.left_x.data(), n, k, work.near_left.data());
  work.right.build(work.right_y.data(), work.right_x.data(), count, k, numbers);
  work.right.nearestToAll(work.right_y.data(), work.right_x.data(), n, k, work.near_right.data());
  if (compat) return;  // the first neighbour is dropped even where it is not the match itself
  takeOutSelf(work.near_left, n, length);
  takeOutSelf(work.near_right, n, length);
}

/// Cost of one neighbourhood with so many common neighbours, so many of which disagree.
double windowCost(int length, int common, int disagreeing, bool count_only) {
  return count_only ? 2.0 * (length - common) : static_cast<double>(length - common + disagreeing) / length;
}

/// Costs from lists of at most 8 neighbours: common ones as bits, see NeighbourKernels.
void costsOfShortLists(const Layout& layout, bool count_only, const MotionRule& rule, LpmMemory& work) {
  const std::size_t n = work.size(), length = static_cast<std::size_t>(layout.listed) + 1;
  work.common.resize(n);
  kernels().neighbours.common(work.near_left.data() + 1, work.near_right.data() + 1, length, layout.listed, n,
                              work.common.data());
  std::uint64_t windows[3] = {}, any = 0;
  for (int w = 0; w < layout.count; ++w) {
    const Window& window = layout.windows[w];
    for (int a = window.begin; a < window.begin + window.length; ++a) {
      for (int b = window.begin; b < window.begin + window.length; ++b) windows[w] |= 1ULL << (8 * a + b);
    }
    any |= windows[w];
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint64_t common = work.common[i] & any;
    std::uint64_t disagreeing = 0;
    for (std::uint64_t left = count_only ? 0 : common; left != 0; left &= left - 1) {
      const auto bit = static_cast<unsigned>(__builtin_ctzll(left));
      const std::uint32_t neighbour = work.near_left[i * length + 1 + bit / 8];
      if (disagree(work.motions[i], work.motions[neighbour], rule)) disagreeing |= left & -left;
    }
    double sum = 0;
    for (int w = 0; w < layout.count; ++w) {
      sum += windowCost(layout.windows[w].length, __builtin_popcountll(common & windows[w]),
                        __builtin_popcountll(disagreeing & windows[w]), count_only);
    }
    work.cost[i] = static_cast<float>(sum / layout.count);
  }
}

/// Costs from lists of any length.
void costsOfLongLists(const Layout& layout, bool count_only, const MotionRule& rule, LpmMemory& work) {
  const std::size_t n = work.size(), length = static_cast<std::size_t>(layout.listed) + 1;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t* const left = work.near_left.data() + i * length + 1;
    const std::uint32_t* const right = work.near_right.data() + i * length + 1;
    double sum = 0;
    for (int w = 0; w < layout.count; ++w) {
      const Window& window = layout.windows[w];
      const std::uint32_t *const begin = right + window.begin, *const end = begin + window.length;
      int common = 0, disagreeing = 0;
      for (int a = window.begin; a < window.begin + window.length; ++a) {
        if (std::find(begin, end, left[a]) == end) continue;
        ++common;
        if (!count_only && disagree(work.motions[i], work.motions[left[a]], rule)) ++disagreeing;
      }
      sum += windowCost(window.length, common, disagreeing, count_only);
    }
    work.cost[i] = static_cast<float>(sum / layout.count);
  }
}

/// One pass: the cost of every match against the neighbourhoods formed by `members`, nullptr = all.
void findCosts(const std::vector<std::uint32_t>* members, const Layout& layout, const LpmOptions& options,
               LpmMemory& work) {
  findNeighbours(members, layout, options.compat, work);
  work.cost.resize(work.size());
  const auto costs = layout.listed <= 8 ? costsOfShortLists : costsOfLongLists;
  costs(layout, options.cost == LpmOptions::Cost::kCount,
        {options.tau, options.noise_floor * options.noise_floor}, work);
}

void acceptWithin(double lambda, LpmMemory& work) {
  // Costs are small fractions. The slack lets a cost of 0.5 pass a test against 0.5 despite rounding.
  work.accepted.clear();
  for (std::size_t i = 0; i < work.cost.size(); ++i) {
    if (work.cost[i] <= lambda + 1e-6) work.accepted.push_back(static_cast<std::uint32_t>(i));
  }
}

}  // namespace

void LpmOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("cost",
                 {{Cost::kCount, "count", "Common neighbours"},
                  {Cost::kMultiscale, "multiscale", "Common neighbours and their motion at three scales"}},
                 "Common neighbours only (count), or also their motion at three scales (multiscale)",
                 &LpmOptions::cost);
  visitor.integer({"k", 1, 32, "-", "Neighbours of a match; multiscale uses k+2, k and k-2"}, &LpmOptions::k);
  visitor.number({"lambda_first", 0, 64, "-", "First pass accepts a match if its cost is at most this"},
                 &LpmOptions::lambda_first);
  visitor.number({"lambda_second", 0, 64, "-", "Second pass accepts a match if its cost is at most this"},
                 &LpmOptions::lambda_second);
  visitor.number(
      {"tau", -1, 1, "-", "Multiscale: common neighbours whose motion agrees less than this do not count"},
      &LpmOptions::tau);
  visitor.number(
      {"noise_floor", 0, 1000, "px",
       "Multiscale: motions that differ by at most this agree, whatever their directions; 0 = off"},
      &LpmOptions::noise_floor);
  visitor.flag("merge_duplicates", "Decide identical matches once, so that they cannot support themselves",
               &LpmOptions::merge_duplicates);
  visitor.flag("compat", "Take neighbours as the authors' code does", &LpmOptions::compat);
  visitConfidence(visitor);
}

void LpmOptions::check() const {
  OptionSet::check();
  if (cost == Cost::kMultiscale && k < 3) {
    throw std::invalid_argument("option k = " + std::to_string(k) +
                                " is too small for cost = multiscale: at least 3");
  }
}

Presets LpmSelector::presets() const {
  return {{"paper", {}},
          {"v1", {{"lambda_second", "4"}}},
          {"v2",
           {{"cost", "multiscale"},
            {"k", "6"},
            {"lambda_first", "0.8"},
            {"lambda_second", "0.5"},
            {"tau", "0.2"}}}};
}

void LpmSelector::run(const Correspondences& matches, Selection& result) const {
  LpmMemory& work = WorkspaceScope::part<LpmMemory>();
  findDistinct(matches, options_.merge_duplicates, work);
  const Layout layout = layoutOf(options_);
  const std::size_t needed = static_cast<std::size_t>(layout.listed) + 2;
  if (work.size() < needed) {
    result.status = Status::kTooFew;
    result.message = std::to_string(work.size()) + " distinct matches, lpm needs " + std::to_string(needed);
    return;
  }
  if (allEqual(work.left_x, work.left_y) || allEqual(work.right_x, work.right_y)) {
    result.status = Status::kDegenerate;
    result.message = "all points of one image are equal: neighbourhoods have no meaning";
    return;
  }
  if (options_.cost == LpmOptions::Cost::kMultiscale) findMotions(work);
  findCosts(nullptr, layout, options_, work);
  acceptWithin(options_.lambda_first, work);
  result.iterations = 1;
  if (work.accepted.size() >= needed) {
    findCosts(&work.accepted, layout, options_, work);
    acceptWithin(options_.lambda_second, work);
    result.iterations = 2;
  }
  work.mask.assign(work.size(), 0);
  for (const std::uint32_t row : work.accepted) work.mask[row] = 1;
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    result.mask[i] = work.mask[work.of_input[i]];
    result.score[i] = -work.cost[work.of_input[i]];
  }
}

}  // namespace corrsel::core
