#include "corrsel/reference/ranks.h"

#include <array>
#include <cstdint>
#include <vector>

#include "points/match_neighbours.h"
#include "reference/rank_distance.h"

namespace corrsel::core {
namespace {

constexpr int kPasses = 3;

/// Memory that is kept between calls.
struct RanksMemory {
  MatchNeighbours all;
  std::vector<std::uint32_t> accepted;
  std::vector<float> cost;
  std::vector<std::uint8_t> mask;
  std::vector<std::uint8_t> place;  // in the left ranking of a match, by number
};

/// One pass with neighbours among `members`, nullptr = all.
void evaluate(const std::vector<std::uint32_t>* members, const std::array<RankDistance, 3>& scales,
              double lambda, RanksMemory& work) {
  MatchNeighbours& all = work.all;
  const int length = scales[0].length();
  all.find(members, length, MatchNeighbours::Self::kKeep);
  work.cost.resize(all.size());
  work.place.assign(all.size(), RankDistance::kAbsent);
  std::uint8_t places[RankDistance::kMax];
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::uint32_t *const left = all.left() + i * all.stride(), *const right =
                                                                         all.right() + i * all.stride();
    for (int a = 0; a < length; ++a) work.place[left[a]] = static_cast<std::uint8_t>(a);
    for (int b = 0; b < length; ++b) places[b] = work.place[right[b]];
    for (int a = 0; a < length; ++a) work.place[left[a]] = RankDistance::kAbsent;
    double sum = 0;
    for (const RankDistance& scale : scales) sum += scale(places);
    work.cost[i] = static_cast<float>(sum / 3);
  }
  work.accepted.clear();
  work.mask.assign(all.size(), 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (work.cost[i] > lambda) continue;
    work.accepted.push_back(static_cast<std::uint32_t>(i));
    work.mask[i] = 1;
  }
}

}  // namespace

void RanksOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"k", 4, 32, "-", "Neighbours of a match; the scales have k, k-2 and k-4"},
                  &RanksOptions::k);
  visitor.number({"lambda_first", 0, 2, "-", "First pass accepts a match if its cost is at most this"},
                 &RanksOptions::lambda_first);
  visitor.number({"lambda_second", 0, 2, "-", "The other passes accept a match if its cost is at most this"},
                 &RanksOptions::lambda_second);
  visitConfidence(visitor);
}

void RanksSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  RanksMemory& work = workspace.part<RanksMemory>();
  work.all.assign(matches, true);
  const auto needed = static_cast<std::size_t>(options_.k) + 2;
  if (!work.all.canForm(needed, name(), result)) return;
  const std::array<RankDistance, 3> scales = {RankDistance(options_.k + 1), RankDistance(options_.k - 1),
                                              RankDistance(options_.k - 3)};
  evaluate(nullptr, scales, options_.lambda_first, work);
  result.iterations = 1;
  while (result.iterations < kPasses && work.accepted.size() >= needed) {
    evaluate(&work.accepted, scales, options_.lambda_second, work);
    ++result.iterations;
  }
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::uint32_t number = work.all.ofRow(i);
    result.mask[i] = work.mask[number];
    result.score[i] = -work.cost[number];
  }
}

}  // namespace corrsel::core
