#include "corrsel/reference/lap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "kernels/kernels.h"
#include "points/match_neighbours.h"

namespace corrsel::core {
namespace {

constexpr int kMaxCandidates = AreaRatioRule::kMaxCandidates;
constexpr int kMaxNeighbours = AreaRatioRule::kMaxNeighbours;

const SaturationTable& saturation() {
  static const SaturationTable kTable = [] {
    SaturationTable table{};
    const auto value = [](int i) {
      return static_cast<float>(-std::expm1(-i / double{SaturationTable::kPerUnit}));
    };
    for (int i = 0; i < SaturationTable::kEntries; ++i) {
      table.values[2 * i] = value(i);
      table.values[2 * i + 1] = value(i + 1) - value(i);
    }
    return table;
  }();
  return kTable;
}

AreaRatioRule ruleOf(const LapOptions& options) {
  const int triples = options.k * (options.k - 1) * (options.k - 2) / 6;
  return {options.candidates, options.k,
          std::max(1, static_cast<int>(std::lround(options.triples_share * triples))),
          static_cast<float>(options.noise_floor * options.noise_floor), &saturation()};
}

/// Memory that is kept between calls.
struct LapMemory {
  MatchNeighbours all;
  std::vector<float> cost_left, cost_right;  // from the neighbours in either image
  std::vector<float> scratch;
};

}  // namespace

void LapOptions::visit(OptionVisitor& visitor) const {
  visitor.integer(
      {"candidates", 3, kMaxCandidates, "-", "Nearest matches among which the neighbours are chosen"},
      &LapOptions::candidates);
  visitor.integer({"k", 3, kMaxNeighbours, "-", "Neighbours: the candidates whose motion agrees best"},
                  &LapOptions::k);
  visitor.number(
      {"triples_share", 0, 1, "-", "Share of the triples of neighbours, the best ones, that count"},
      &LapOptions::triples_share);
  visitor.number({"lambda", 0, 3, "-", "A match is accepted if its cost is at most this"},
                 &LapOptions::lambda);
  visitor.number({"noise_floor", 0, 1000, "px", "Motions that differ by at most this agree; 0 = off"},
                 &LapOptions::noise_floor);
  visitConfidence(visitor);
}

void LapOptions::check() const {
  OptionSet::check();
  if (k > candidates) {
    throw std::invalid_argument("option k = " + std::to_string(k) +
                                " is larger than candidates = " + std::to_string(candidates));
  }
}

void LapSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  LapMemory& work = workspace.part<LapMemory>();
  MatchNeighbours& all = work.all;
  all.assign(matches, true);
  if (!all.canForm(static_cast<std::size_t>(options_.candidates) + 1, name(), result)) return;
  const std::size_t n = all.size();
  all.find(nullptr, options_.candidates, MatchNeighbours::Self::kLeaveOut);
  const AreaRatioRule rule = ruleOf(options_);
  const MatchColumns columns = {all.left_x.data(), all.left_y.data(), all.right_x.data(), all.right_y.data(),
                                n};
  const auto costs = kernels().area_ratio.costs;
  work.cost_left.resize(n);
  work.cost_right.resize(n);
  work.scratch.resize(rule.scratchSize());
  costs(columns, all.left(), all.stride(), rule, work.scratch.data(), work.cost_left.data());
  costs(columns, all.right(), all.stride(), rule, work.scratch.data(), work.cost_right.data());
  result.iterations = 1;
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::uint32_t number = all.ofRow(i);
    const float own = (work.cost_left[number] + work.cost_right[number]) / 2;
    result.mask[i] = own <= options_.lambda ? 1 : 0;
    result.score[i] = -own;
  }
}

}  // namespace corrsel::core
