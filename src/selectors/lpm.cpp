#include "corrsel/selectors/lpm.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "kernels/kernels.h"
#include "points/match_neighbours.h"
#include "selectors/parts/trusted_set.h"

namespace corrsel::core {
namespace {

// The passes among the trusted matches: preset v1.
constexpr int kGuideNeighbours = 4;
constexpr double kGuideLambdaFirst = 6, kGuideLambdaSecond = 4;

/// A window [begin, begin + length) of the neighbour list that forms one neighbourhood.
struct Window {
  int begin, length;
};

/// Neighbourhoods, and how many neighbours they need to be listed.
struct Layout {
  Window windows[3] = {};
  int count = 1, listed = 0;
};

Layout countLayout(int k) {
  Layout layout;
  layout.windows[0] = {0, k};
  layout.listed = k;
  return layout;
}

Layout layoutOf(const LpmOptions& options) {
  if (options.cost == LpmOptions::Cost::kCount) return countLayout(options.k);
  Layout layout;
  // The authors' code slices its table again at every scale and so loses one more of the nearest each time.
  layout.count = 3;
  for (int i = 0; i < 3; ++i) layout.windows[i] = {i, options.k + 2 - 2 * i};
  for (const Window& window : layout.windows)
    layout.listed = std::max(layout.listed, window.begin + window.length);
  return layout;
}

/// Motion of a match, px, and its squared length.
struct Motion {
  double x, y, squared;
};

/// Memory that is kept between calls.
struct LpmMemory {
  MatchNeighbours all, trusted;
  TrustedSet trusted_set;
  std::vector<Motion> motions;
  std::vector<std::uint64_t> common;  // see NeighbourKernels
  std::vector<float> cost;
  std::vector<std::uint32_t> accepted;
  std::vector<std::uint8_t> mask;
};

void findMotions(const MatchNeighbours& matches, std::vector<Motion>& motions) {
  motions.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const double x = static_cast<double>(matches.right_x[i]) - matches.left_x[i];
    const double y = static_cast<double>(matches.right_y[i]) - matches.left_y[i];
    motions[i] = {x, y, x * x + y * y};
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

/// Cost of one neighbourhood with so many common neighbours, so many of which disagree.
double windowCost(int length, int common, int disagreeing, bool count_only) {
  return count_only ? 2.0 * (length - common) : static_cast<double>(length - common + disagreeing) / length;
}

/// Costs from lists of at most 8 neighbours: common ones as bits, see NeighbourKernels.
void costsOfShortLists(const MatchNeighbours& matches, const Layout& layout, bool count_only,
                       const MotionRule& rule, LpmMemory& work) {
  const std::size_t n = matches.size(), stride = matches.stride();
  work.common.resize(n);
  kernels().neighbours.common(matches.left(), matches.right(), stride, layout.listed, n, work.common.data());
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
      const std::uint32_t neighbour = matches.left()[i * stride + bit / 8];
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
void costsOfLongLists(const MatchNeighbours& matches, const Layout& layout, bool count_only,
                      const MotionRule& rule, LpmMemory& work) {
  const std::size_t n = matches.size(), stride = matches.stride();
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t* const left = matches.left() + i * stride;
    const std::uint32_t* const right = matches.right() + i * stride;
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

/// Costs of all matches against the neighbourhoods formed by `members`, nullptr = all.
void findCosts(MatchNeighbours& matches, const std::vector<std::uint32_t>* members, const Layout& layout,
               const LpmOptions& options, LpmMemory& work) {
  matches.find(members, layout.listed, MatchNeighbours::Self::kDropNearest);
  work.cost.resize(matches.size());
  const auto costs = layout.listed <= 8 ? costsOfShortLists : costsOfLongLists;
  costs(matches, layout, layout.count == 1, {options.tau, options.noise_floor * options.noise_floor}, work);
}

void acceptWithin(double lambda, LpmMemory& work) {
  // Costs are small fractions. The slack lets a cost of 0.5 pass a test against 0.5 despite rounding.
  work.accepted.clear();
  for (std::size_t i = 0; i < work.cost.size(); ++i) {
    if (work.cost[i] <= lambda + 1e-6) work.accepted.push_back(static_cast<std::uint32_t>(i));
  }
}

/// Two passes of LPM among the trusted matches. @return whether work.accepted, the survivors, can guide
bool findGuides(const Correspondences& matches, const LpmOptions& options, std::size_t needed,
                LpmMemory& work) {
  const Layout layout = countLayout(kGuideNeighbours);
  work.trusted_set.find(matches, options.guide_ratio);
  work.trusted.assign(matches, options.merge_duplicates, &work.trusted_set.mask());
  const auto enough = static_cast<std::size_t>(layout.listed) + 2;
  if (work.trusted.size() < std::max({TrustedSet::kMinMatches, enough, needed})) return false;
  findCosts(work.trusted, nullptr, layout, options, work);
  acceptWithin(kGuideLambdaFirst, work);
  if (work.accepted.size() >= enough) {
    findCosts(work.trusted, &work.accepted, layout, options, work);
    acceptWithin(kGuideLambdaSecond, work);
  }
  for (std::uint32_t& number : work.accepted) number = work.all.ofRow(work.trusted.rowOf(number));
  return work.accepted.size() >= needed;
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
  visitor.flag("guided",
               "Form the first neighbourhoods from the trusted matches that survive LPM among themselves",
               &LpmOptions::guided);
  visitor.number({"guide_ratio", 0, 1, "-", "Guided: trusted matches have a distance ratio below this"},
                 &LpmOptions::guide_ratio);
  visitor.flag("merge_duplicates", "Decide identical matches once, so that they cannot support themselves",
               &LpmOptions::merge_duplicates);
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
            {"tau", "0.2"}}},
          {"guided", {{"guided", "true"}, {"k", "6"}}}};
}

std::string LpmSelector::missingInput(const Correspondences& matches) const {
  return options_.guided ? TrustedSet::missingInput(matches, "lpm with guided = true") : "";
}

void LpmSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  LpmMemory& work = workspace.part<LpmMemory>();
  MatchNeighbours& all = work.all;
  all.assign(matches, options_.merge_duplicates);
  const Layout layout = layoutOf(options_);
  const std::size_t needed = static_cast<std::size_t>(layout.listed) + 2;
  if (!all.canForm(needed, "lpm", result)) return;
  if (options_.cost == LpmOptions::Cost::kMultiscale) findMotions(all, work.motions);
  const bool guided = options_.guided && findGuides(matches, options_, needed, work);
  findCosts(all, guided ? &work.accepted : nullptr, layout, options_, work);
  acceptWithin(options_.lambda_first, work);
  result.iterations = 1;
  if (work.accepted.size() >= needed) {
    findCosts(all, &work.accepted, layout, options_, work);
    acceptWithin(options_.lambda_second, work);
    result.iterations = 2;
  }
  work.mask.assign(all.size(), 0);
  for (const std::uint32_t number : work.accepted) work.mask[number] = 1;
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    result.mask[i] = work.mask[all.ofRow(i)];
    result.score[i] = -work.cost[all.ofRow(i)];
  }
}

}  // namespace corrsel::core
