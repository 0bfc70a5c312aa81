#include "corrsel/selectors/lpm.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "corrsel/selectors/neighbours.h"

namespace corrsel::core {
namespace {

/// A window [begin, begin + length) of the neighbour list that forms one neighbourhood.
struct Window {
  int begin, length;
};

/// Neighbourhoods, and how many neighbours they need to be listed.
struct Layout {
  std::vector<Window> windows;
  int listed = 0;
};

Layout layoutOf(const LpmOptions& options) {
  Layout layout;
  if (options.cost == "count") {
    layout.windows = {{0, options.k}};
  } else {
    // The authors' code slices its table anew at every scale and so loses one more of the nearest each time.
    const int step = options.compat ? 1 : 0;
    layout.windows = {{0, options.k + 2}, {step, options.k}, {2 * step, options.k - 2}};
  }
  for (const Window& window : layout.windows)
    layout.listed = std::max(layout.listed, window.begin + window.length);
  return layout;
}

/// Distinct matches in the order of their coordinates, which makes numbers of matches a tie rule that does
/// not depend on the order of the input.
struct Distinct {
  std::vector<float> left_x, left_y, right_x, right_y;
  std::vector<std::uint32_t> of_input;  // per input match: its distinct match
  std::size_t size() const { return left_x.size(); }
};

Distinct distinctMatches(const Correspondences& matches, bool merge) {
  const std::size_t n = matches.size();
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  const auto compare = [&matches](std::uint32_t a, std::uint32_t b) {
    if (matches.left_x[a] != matches.left_x[b]) return matches.left_x[a] < matches.left_x[b] ? -1 : 1;
    if (matches.left_y[a] != matches.left_y[b]) return matches.left_y[a] < matches.left_y[b] ? -1 : 1;
    if (matches.right_x[a] != matches.right_x[b]) return matches.right_x[a] < matches.right_x[b] ? -1 : 1;
    if (matches.right_y[a] != matches.right_y[b]) return matches.right_y[a] < matches.right_y[b] ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&compare](std::uint32_t a, std::uint32_t b) {
    const int result = compare(a, b);
    return result != 0 ? result < 0 : a < b;
  });
  Distinct distinct;
  distinct.of_input.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t row = order[i];
    if (i == 0 || !merge || compare(order[i - 1], row) != 0) {
      distinct.left_x.push_back(matches.left_x[row]);
      distinct.left_y.push_back(matches.left_y[row]);
      distinct.right_x.push_back(matches.right_x[row]);
      distinct.right_y.push_back(matches.right_y[row]);
    }
    distinct.of_input[row] = static_cast<std::uint32_t>(distinct.size() - 1);
  }
  return distinct;
}

bool allEqual(const std::vector<float>& x, const std::vector<float>& y) {
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (x[i] != x[0] || y[i] != y[0]) return false;
  }
  return true;
}

/// Neighbour lists of one match, the match itself taken out.
class NeighbourLists {
 public:
  NeighbourLists(const std::vector<float>& x, const std::vector<float>& y,
                 const std::vector<std::uint32_t>& members, int listed, bool drop_first)
      : members_(members),
        listed_(listed),
        drop_first_(drop_first),
        found_(static_cast<std::size_t>(listed) + 1),
        index_(pick(x, members).data(), pick(y, members).data(), members.size(), listed + 1) {}

  /// Writes exactly `listed` match numbers, nearest first. @pre more members than `listed`
  void of(std::uint32_t match, float x, float y, std::uint32_t* out) {
    const int found = index_.nearest(x, y, listed_ + 1, found_.data());
    int written = 0;
    for (int i = drop_first_ ? 1 : 0; i < found && written < listed_; ++i) {
      const std::uint32_t neighbour = members_[found_[static_cast<std::size_t>(i)]];
      if (drop_first_ || neighbour != match) out[written++] = neighbour;
    }
  }

 private:
  static std::vector<float> pick(const std::vector<float>& column, const std::vector<std::uint32_t>& rows) {
    std::vector<float> picked;
    picked.reserve(rows.size());
    for (const std::uint32_t row : rows) picked.push_back(column[row]);
    return picked;
  }

  const std::vector<std::uint32_t>& members_;
  int listed_;
  bool drop_first_;
  std::vector<std::uint32_t> found_;
  PlanarNeighbours index_;
};

/// 1 where two motions agree in direction and length, see the class documentation.
double motionAgreement(const Distinct& matches, std::uint32_t i, std::uint32_t j) {
  const double ix = static_cast<double>(matches.right_x[i]) - matches.left_x[i];
  const double iy = static_cast<double>(matches.right_y[i]) - matches.left_y[i];
  const double jx = static_cast<double>(matches.right_x[j]) - matches.left_x[j];
  const double jy = static_cast<double>(matches.right_y[j]) - matches.left_y[j];
  const double ii = ix * ix + iy * iy, jj = jx * jx + jy * jy;
  if (ii == 0 || jj == 0) return ii == jj ? 1.0 : 0.0;
  return (ix * jx + iy * jy) / std::sqrt(ii * jj) * std::min(ii, jj) / std::max(ii, jj);
}

/// One pass: the cost of every match against the neighbourhoods formed by `members`.
std::vector<float> costs(const Distinct& matches, const std::vector<std::uint32_t>& members,
                         const Layout& layout, const LpmOptions& options) {
  NeighbourLists left(matches.left_x, matches.left_y, members, layout.listed, options.compat);
  NeighbourLists right(matches.right_x, matches.right_y, members, layout.listed, options.compat);
  std::vector<std::uint32_t> near_left(static_cast<std::size_t>(layout.listed)), near_right(near_left);
  const bool count_only = options.cost == "count";
  std::vector<float> result(matches.size());
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    left.of(i, matches.left_x[i], matches.left_y[i], near_left.data());
    right.of(i, matches.right_x[i], matches.right_y[i], near_right.data());
    double sum = 0;
    for (const Window& window : layout.windows) {
      const auto begin = near_right.begin() + window.begin, end = begin + window.length;
      int common = 0, disagreeing = 0;
      for (int a = window.begin; a < window.begin + window.length; ++a) {
        const std::uint32_t neighbour = near_left[static_cast<std::size_t>(a)];
        if (std::find(begin, end, neighbour) == end) continue;
        ++common;
        if (!count_only && motionAgreement(matches, i, neighbour) < options.tau) ++disagreeing;
      }
      sum += count_only ? 2.0 * (window.length - common)
                        : static_cast<double>(window.length - common + disagreeing) / window.length;
    }
    result[i] = static_cast<float>(sum / static_cast<double>(layout.windows.size()));
  }
  return result;
}

std::vector<std::uint32_t> within(const std::vector<float>& cost, double lambda) {
  // Costs are small fractions: the slack keeps 0.5 from failing a test against 0.5 for its last bit.
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < cost.size(); ++i) {
    if (cost[i] <= lambda + 1e-6) rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

}  // namespace

void LpmOptions::visit(OptionVisitor& visitor) {
  visitor.choice("cost", {"count", "multiscale"},
                 "Common neighbours only (count), or also their motion at three scales (multiscale)", cost);
  visitor.integer({"k", 1, 32, "-", "Neighbours of a match; multiscale uses k+2, k and k-2"}, k);
  visitor.number({"lambda_first", 0, 64, "-", "First pass accepts a match if its cost is at most this"},
                 lambda_first);
  visitor.number({"lambda_second", 0, 64, "-", "Second pass accepts a match if its cost is at most this"},
                 lambda_second);
  visitor.number(
      {"tau", -1, 1, "-", "Multiscale: common neighbours whose motion agrees less than this do not count"},
      tau);
  visitor.flag("merge_duplicates", "Decide identical matches once, so that they cannot support themselves",
               merge_duplicates);
  visitor.flag("compat", "Take neighbours as the authors' code does", compat);
}

void LpmOptions::check() const {
  OptionSet::check();
  if (cost == "multiscale" && k < 3) {
    throw std::invalid_argument("option k = " + std::to_string(k) +
                                " is too small for cost = multiscale: at least 3");
  }
}

LpmSelector::LpmSelector(LpmOptions options) : options_(std::move(options)) { options_.check(); }

Presets LpmSelector::presets() {
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
  const Distinct distinct = distinctMatches(matches, options_.merge_duplicates);
  const Layout layout = layoutOf(options_);
  const std::size_t needed = static_cast<std::size_t>(layout.listed) + 2;
  if (distinct.size() < needed) {
    result.status = Status::kTooFew;
    result.message =
        std::to_string(distinct.size()) + " distinct matches, lpm needs " + std::to_string(needed);
    return;
  }
  if (allEqual(distinct.left_x, distinct.left_y) || allEqual(distinct.right_x, distinct.right_y)) {
    result.status = Status::kDegenerate;
    result.message = "all points of one image are equal: neighbourhoods have no meaning";
    return;
  }
  std::vector<std::uint32_t> members(distinct.size());
  std::iota(members.begin(), members.end(), 0U);
  std::vector<float> cost = costs(distinct, members, layout, options_);
  std::vector<std::uint32_t> accepted = within(cost, options_.lambda_first);
  result.iterations = 1;
  if (accepted.size() >= needed) {
    cost = costs(distinct, accepted, layout, options_);
    accepted = within(cost, options_.lambda_second);
    result.iterations = 2;
  }
  std::vector<std::uint8_t> mask(distinct.size(), 0);
  for (const std::uint32_t row : accepted) mask[row] = 1;
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    result.mask[i] = mask[distinct.of_input[i]];
    result.score[i] = -cost[distinct.of_input[i]];
  }
}

}  // namespace corrsel::core
