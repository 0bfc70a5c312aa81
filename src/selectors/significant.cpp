#include "corrsel/selectors/significant.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "points/match_neighbours.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 4;
constexpr double kPi = 3.14159265358979323846;
constexpr float kSamePoint = 1;  // px

/// Memory that is kept between calls.
struct SignificantMemory {
  MatchNeighbours all;
  std::vector<std::uint32_t> accepted;
  std::vector<double> nfa;  // log10 of the number of false alarms
};

double areaOf(const Correspondences& matches, const MatchNeighbours& all) {
  double width = matches.right_size.width, height = matches.right_size.height;
  if (width <= 0 || height <= 0) {
    const auto [low_x, high_x] = std::minmax_element(all.right_x.begin(), all.right_x.end());
    const auto [low_y, high_y] = std::minmax_element(all.right_y.begin(), all.right_y.end());
    width = static_cast<double>(*high_x) - *low_x;
    height = static_cast<double>(*high_y) - *low_y;
  }
  return std::max(1.0, width * height);
}

/// One pass with neighbours among `members`, nullptr = all.
void evaluate(const std::vector<std::uint32_t>* members, double area, const SignificantOptions& options,
              SignificantMemory& work) {
  MatchNeighbours& all = work.all;
  const std::size_t n = all.size(), max_neighbours = (members != nullptr ? members->size() : n) - 1;
  const int listed = static_cast<int>(std::min(max_neighbours, static_cast<std::size_t>(options.k)));
  all.findLeft(members, listed, MatchNeighbours::Self::kLeaveOut);
  const double log10_matches = std::log10(static_cast<double>(n));
  const auto deformation = static_cast<float>(options.deformation), slack = static_cast<float>(options.slack);
  work.nfa.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t* const list = all.left() + i * all.stride();
    std::size_t neighbours = 0, agreeing = 0;
    double chance = 0;
    for (int s = 0; s < listed; ++s) {
      const std::uint32_t j = list[s];
      const float dx = all.left_x[j] - all.left_x[i], dy = all.left_y[j] - all.left_y[i];
      const float ux = all.right_x[j] - all.right_x[i], uy = all.right_y[j] - all.right_y[i];
      const float squared = dx * dx + dy * dy;
      if (squared < kSamePoint * kSamePoint || ux * ux + uy * uy < kSamePoint * kSamePoint) continue;
      const float reach = deformation * std::sqrt(squared) + slack, ex = ux - dx, ey = uy - dy;
      ++neighbours;
      agreeing += ex * ex + ey * ey <= reach * reach ? 1 : 0;
      chance += std::min(1.0, kPi * reach * reach / area);
    }
    const double mean = neighbours > 0 ? chance / static_cast<double>(neighbours) : 1;
    work.nfa[i] = log10_matches + log10BinomialTail(neighbours, agreeing, mean);
  }
  work.accepted.clear();
  for (std::size_t i = 0; i < n; ++i) {
    if (work.nfa[i] < options.cut) work.accepted.push_back(static_cast<std::uint32_t>(i));
  }
}

}  // namespace

void SignificantOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"k", 1, 32, "-", "Neighbours of a match in the left image"}, &SignificantOptions::k);
  visitor.number(
      {"deformation", 0, 2, "-", "Share of the distance by which the motions of neighbours may differ"},
      &SignificantOptions::deformation);
  visitor.number({"slack", 0, 50, "px", "Differences of motion that are always tolerated"},
                 &SignificantOptions::slack);
  visitor.number(
      {"cut", -1000, 10, "-", "A match is accepted if log10 of its number of false alarms is below this"},
      &SignificantOptions::cut);
  visitConfidence(visitor);
}

void SignificantSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  SignificantMemory& work = workspace.part<SignificantMemory>();
  work.all.assign(matches, true);
  if (!work.all.canForm(kMinMatches, name(), result)) return;
  const double area = areaOf(matches, work.all);
  evaluate(nullptr, area, options_, work);
  result.iterations = 1;
  if (work.accepted.size() >= kMinMatches) {
    evaluate(&work.accepted, area, options_, work);
    result.iterations = 2;
  }
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const double nfa = work.nfa[work.all.ofRow(i)];
    result.mask[i] = nfa < options_.cut ? 1 : 0;
    result.score[i] = static_cast<float>(-nfa);
  }
}

}  // namespace corrsel::core
