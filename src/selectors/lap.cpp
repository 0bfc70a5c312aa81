#include "corrsel/selectors/lap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "base/workspace_scope.h"
#include "selectors/parts/match_neighbours.h"

namespace corrsel::core {
namespace {

constexpr int kMostCandidates = 60, kMostNeighbours = 20;
constexpr std::size_t kMostTriples = kMostNeighbours * (kMostNeighbours - 1) * (kMostNeighbours - 2) / 6;

/// 1 - exp(-z) for z >= 0, interpolated.
class Saturation {
 public:
  Saturation() {
    for (int i = 0; i <= kEntries; ++i) values_[i] = static_cast<float>(-std::expm1(-i / double{kPerUnit}));
  }

  float operator()(float z) const {
    if (!(z < kLargest)) return 1;
    const float place = z * kPerUnit;
    const auto index = static_cast<std::int32_t>(place);
    return values_[index] + (values_[index + 1] - values_[index]) * (place - static_cast<float>(index));
  }

 private:
  static constexpr int kPerUnit = 100, kLargest = 16, kEntries = kPerUnit * kLargest;
  float values_[kEntries + 1];
};

const Saturation& saturation() {
  static const Saturation kTable;
  return kTable;
}

/// A candidate for a neighbour, with its agreement c.
struct Candidate {
  float agreement;
  std::uint32_t number;
};

/// Memory that is kept between calls.
struct LapMemory {
  MatchNeighbours all;
  std::vector<float> motion_x, motion_y, squared;
  std::vector<float> cost;
};

float agreementOf(const LapMemory& work, std::size_t i, std::uint32_t j, float squared_floor) {
  const float dx = work.motion_x[i] - work.motion_x[j], dy = work.motion_y[i] - work.motion_y[j];
  const float squared = dx * dx + dy * dy;
  if (squared <= squared_floor) return 1.5F;
  const float shorter = std::min(work.squared[i], work.squared[j]);
  const float longer = std::max(work.squared[i], work.squared[j]);
  if (shorter <= squared_floor) return std::sqrt(squared_floor / squared);
  const float dot = work.motion_x[i] * work.motion_x[j] + work.motion_y[i] * work.motion_y[j];
  return dot / std::sqrt(shorter * longer) / 2 + shorter / longer;
}

/// The areas of the triangles that a match forms with two neighbours each.
struct Areas {
  float of[kMostNeighbours][kMostNeighbours], inverse[kMostNeighbours][kMostNeighbours];

  void fill(const std::vector<float>& x, const std::vector<float>& y, std::size_t centre,
            const Candidate* neighbours, int count) {
    float dx[kMostNeighbours], dy[kMostNeighbours];
    for (int a = 0; a < count; ++a) {
      dx[a] = x[neighbours[a].number] - x[centre];
      dy[a] = y[neighbours[a].number] - y[centre];
    }
    for (int a = 0; a < count; ++a) {
      for (int b = a + 1; b < count; ++b) {
        of[a][b] = std::abs(dx[a] * dy[b] - dx[b] * dy[a]);
        inverse[a][b] = 1 / of[a][b];
      }
    }
  }
};

/// The cost of a match from its nearest matches in one image.
class Cost {
 public:
  explicit Cost(const LapOptions& options)
      : candidates_(options.candidates),
        neighbours_(options.k),
        squared_floor_(static_cast<float>(options.noise_floor * options.noise_floor)),
        saturation_(saturation()) {
    const int triples = options.k * (options.k - 1) * (options.k - 2) / 6;
    kept_ = std::max(1, static_cast<int>(std::lround(options.triples_share * triples)));
  }

  float operator()(const LapMemory& work, std::size_t i, const std::uint32_t* list) const {
    Candidate near[kMostCandidates];
    for (int s = 0; s < candidates_; ++s) near[s] = {agreementOf(work, i, list[s], squared_floor_), list[s]};
    // Insertion keeps candidates with equal agreement in the order of their distances.
    for (int s = 1; s < candidates_; ++s) {
      const Candidate moved = near[s];
      if (s >= neighbours_ && !(moved.agreement > near[neighbours_ - 1].agreement)) continue;
      int place = std::min(s, neighbours_ - 1);
      for (; place > 0 && moved.agreement > near[place - 1].agreement; --place) near[place] = near[place - 1];
      near[place] = moved;
    }
    const MatchNeighbours& all = work.all;
    Areas left, right;
    left.fill(all.left_x, all.left_y, i, near, neighbours_);
    right.fill(all.right_x, all.right_y, i, near, neighbours_);
    float deviations[kMostTriples];
    int count = 0;
    for (int a = 0; a < neighbours_; ++a) {
      for (int b = a + 1; b < neighbours_; ++b) {
        const float l1 = left.of[a][b], r1 = right.of[a][b];
        for (int c = b + 1; c < neighbours_; ++c) {
          // Without an area, the ratio is infinite or NaN, and the deviation 1.
          const float l2 = left.inverse[b][c], l3 = left.inverse[a][c];
          const float r2 = right.inverse[b][c], r3 = right.inverse[a][c];
          deviations[count++] = saturation_(std::abs(l1 * l2 - r1 * r2)) +
                                saturation_(std::abs(l1 * l3 - r1 * r3)) +
                                saturation_(std::abs(left.of[b][c] * l3 - right.of[b][c] * r3));
        }
      }
    }
    std::nth_element(deviations, deviations + kept_ - 1, deviations + count);
    double sum = 0;
    for (int t = 0; t < kept_; ++t) sum += deviations[t];
    return static_cast<float>(sum / kept_);
  }

 private:
  int candidates_, neighbours_, kept_;
  float squared_floor_;
  const Saturation& saturation_;
};

}  // namespace

void LapOptions::visit(OptionVisitor& visitor) const {
  visitor.integer(
      {"candidates", 3, kMostCandidates, "-", "Nearest matches among which the neighbours are chosen"},
      &LapOptions::candidates);
  visitor.integer({"k", 3, kMostNeighbours, "-", "Neighbours: the candidates whose motion agrees best"},
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

void LapSelector::run(const Correspondences& matches, Selection& result) const {
  LapMemory& work = WorkspaceScope::part<LapMemory>();
  MatchNeighbours& all = work.all;
  all.assign(matches, true);
  if (!all.canForm(static_cast<std::size_t>(options_.candidates) + 1, name(), result)) return;
  const std::size_t n = all.size();
  for (std::vector<float>* column : {&work.motion_x, &work.motion_y, &work.squared, &work.cost})
    column->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float x = all.right_x[i] - all.left_x[i], y = all.right_y[i] - all.left_y[i];
    work.motion_x[i] = x;
    work.motion_y[i] = y;
    work.squared[i] = x * x + y * y;
  }
  all.find(nullptr, options_.candidates, MatchNeighbours::Self::kLeaveOut);
  const Cost cost(options_);
  for (std::size_t i = 0; i < n; ++i) {
    work.cost[i] =
        (cost(work, i, all.left() + i * all.stride()) + cost(work, i, all.right() + i * all.stride())) / 2;
  }
  result.iterations = 1;
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const float own = work.cost[all.ofRow(i)];
    result.mask[i] = own <= options_.lambda ? 1 : 0;
    result.score[i] = -own;
  }
}

}  // namespace corrsel::core
