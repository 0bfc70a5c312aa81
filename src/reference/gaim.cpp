#include "corrsel/reference/gaim.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/frame_map.h"
#include "points/distinct_matches.h"
#include "points/point_groups.h"
#include "reference/pair_graph.h"
#include "selectors/parts/degenerate_input.h"

namespace corrsel::core {
namespace {

constexpr double kSamePixel = 1;  // px
constexpr double kDistinctiveness = 0.5;
// The agreement of a pair is a whole number up to this, so that sums do not depend on their order.
constexpr std::int32_t kFullAgreement = 1 << 16;

/// A pair of neighbours that agree.
struct Edge {
  std::uint32_t match;
  std::int32_t agreement;
};

/// Memory that is kept between calls.
struct GaimMemory {
  std::vector<LinearMap> maps;
  std::vector<std::uint32_t> rows;  // matches with a map
  DistinctMatches distinct;
  PairGraph graph;
  std::vector<float> errors;                 // of the neighbours of a match
  std::vector<std::int32_t> agreement;       // of every match with its neighbours, in the order of the graph
  std::vector<std::uint32_t> begin, filled;  // of the edges of a match; one more than matches
  std::vector<Edge> edges;                   // of each match, in both directions
  std::vector<std::int64_t> support;         // agreement of each match with its kept neighbours
  std::vector<double> own;                   // theta - (1 - r) / 2 of each match
  std::vector<std::uint8_t> kept;
  std::vector<std::uint32_t> waiting;  // matches to drop
  std::vector<float> x, y;
  PointGroups points;
  std::vector<std::uint32_t> best;  // match by point
};

/// (1 - r) / 2, where r is the ratio of descriptor distances.
double distinctiveness(const Correspondences& m, std::uint32_t row) {
  if (m.distance.empty() || m.second_distance.empty()) return 0;
  const double ratio = double{m.distance[row]} / m.second_distance[row];
  // Comparisons with NaN are false.
  return ratio >= 0 && ratio < 1 ? kDistinctiveness * (1 - ratio) : 0;
}

/// Lists the pairs that agree for both of their matches, and sums the agreement of every match.
void joinMatches(float max_error, GaimMemory& work) {
  const std::size_t n = work.graph.size(), degree = work.graph.degree();
  work.errors.resize(degree);
  work.agreement.resize(n * degree);
  work.begin.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    work.graph.errors(i, work.errors.data());
    const std::uint32_t* const neighbours = work.graph.neighbours(i);
    for (std::size_t k = 0; k < degree; ++k) {
      const float share = work.errors[k] < max_error ? 1 - work.errors[k] / max_error : 0;
      const auto agreement = static_cast<std::int32_t>(share * kFullAgreement);
      work.agreement[i * degree + k] = agreement;
      if (agreement == 0) continue;
      ++work.begin[i + 1];
      ++work.begin[neighbours[k] + 1];
    }
  }
  for (std::size_t i = 0; i < n; ++i) work.begin[i + 1] += work.begin[i];
  work.filled.assign(work.begin.begin(), work.begin.end() - 1);
  work.edges.resize(work.begin[n]);
  work.support.assign(n, 0);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t* const neighbours = work.graph.neighbours(i);
    for (std::size_t k = 0; k < degree; ++k) {
      const std::int32_t agreement = work.agreement[i * degree + k];
      if (agreement == 0) continue;
      const std::uint32_t j = neighbours[k];
      work.edges[work.filled[i]++] = {j, agreement};
      work.edges[work.filled[j]++] = {i, agreement};
      work.support[i] += agreement;
      work.support[j] += agreement;
    }
  }
}

/// Drops matches until each that is kept lowers the energy.
/// @param reward  energy per unit of support
/// @return the number of dropped matches
std::size_t dropMatches(double reward, GaimMemory& work) {
  const std::size_t n = work.graph.size();
  work.kept.assign(n, 1);
  work.waiting.clear();
  std::size_t dropped = 0;
  const auto dropIfUseless = [&](std::uint32_t i) {
    if (work.kept[i] == 0 || work.own[i] < reward * static_cast<double>(work.support[i])) return;
    work.kept[i] = 0;
    work.waiting.push_back(i);
    ++dropped;
  };
  for (std::uint32_t first = 0; first < n; ++first) {
    dropIfUseless(first);
    while (!work.waiting.empty()) {
      const std::uint32_t i = work.waiting.back();
      work.waiting.pop_back();
      for (std::size_t e = work.begin[i]; e < work.begin[i + 1]; ++e) {
        work.support[work.edges[e].match] -= work.edges[e].agreement;
        dropIfUseless(work.edges[e].match);
      }
    }
  }
  return dropped;
}

/// Of the kept matches that share a point, keeps the one that lowers the energy most, the first of equal
/// ones.
void keepBestOfPoints(const float* x, const float* y, double reward, GaimMemory& work) {
  const std::size_t n = work.kept.size();
  work.x.assign(x, x + n);
  work.y.assign(y, y + n);
  work.points.number(work.x, work.y, kSamePixel);
  work.best.assign(work.points.sizes.size(), DistinctMatches::kNone);
  const auto energy = [&](std::uint32_t i) {
    return work.own[i] - reward * static_cast<double>(work.support[i]);
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    std::uint32_t& best = work.best[work.points.of[i]];
    if (work.kept[i] != 0 && (best == DistinctMatches::kNone || energy(i) < energy(best))) best = i;
  }
  for (std::uint32_t i = 0; i < n; ++i) work.kept[i] = work.best[work.points.of[i]] == i ? 1 : 0;
}

}  // namespace

void GaimOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"k", 1, PairGraph::kMaxNeighbours, "-", "Neighbours of a match"}, &GaimOptions::k);
  visitor.number({"theta", -100, 100, "-", "Energy of a match that is kept, before its rewards"},
                 &GaimOptions::theta);
  visitor.number({"lambda", 0, 1000, "-", "Reward of a match all of whose neighbours agree"},
                 &GaimOptions::lambda);
  visitor.number({"max_error", 0.01, 1000, "px", "Error at which a pair of neighbours earns no reward"},
                 &GaimOptions::max_error);
  visitor.flag("one_to_one", "Keep only the best match of every left and every right point",
               &GaimOptions::one_to_one);
  visitConfidence(visitor);
}

std::string GaimSelector::missingInput(const Correspondences& matches) const {
  return missingFrames(matches, "gaim");
}

void GaimSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  GaimMemory& work = workspace.part<GaimMemory>();
  findFrameMaps(matches, work.maps, work.rows);
  if (endsAtFrames(matches, work.rows.size(), result)) return;
  work.distinct.assign(matches, work.maps, work.rows);
  const std::size_t distinct = work.distinct.size();
  const PairColumns columns = work.distinct.columns();
  work.graph.build(columns, distinct, options_.k);
  joinMatches(static_cast<float>(options_.max_error), work);
  work.own.assign(distinct, options_.theta);
  for (const std::uint32_t row : work.rows) {
    double& own = work.own[work.distinct.ofRow(row)];
    own = std::min(own, options_.theta - distinctiveness(matches, row));
  }
  const double reward = options_.lambda / (2.0 * options_.k * kFullAgreement);
  const std::size_t dropped = dropMatches(reward, work);
  if (dropped == distinct && result.message.empty())
    result.message = "no match is supported by its neighbours";
  if (options_.one_to_one) {
    keepBestOfPoints(columns.right_x, columns.right_y, reward, work);
    keepBestOfPoints(columns.left_x, columns.left_y, reward, work);
  }
  result.iterations = dropped + 1;
  result.score.assign(n, std::numeric_limits<float>::quiet_NaN());
  for (const std::uint32_t row : work.rows) {
    const std::uint32_t i = work.distinct.ofRow(row);
    result.score[row] =
        static_cast<float>(options_.theta - work.own[i] + reward * static_cast<double>(work.support[i]));
    result.mask[row] = work.kept[i];
  }
}

}  // namespace corrsel::core
