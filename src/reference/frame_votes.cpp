#include "corrsel/reference/frame_votes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "geometry/frame_map.h"
#include "points/distinct_matches.h"
#include "points/point_groups.h"
#include "reference/cluster_numbers.h"
#include "reference/pair_graph.h"
#include "selectors/parts/degenerate_input.h"
#include "selectors/parts/otsu.h"

namespace corrsel::core {
namespace {

constexpr int kOtsuBins = 256;
constexpr double kSamePixel = 1;  // px

/// Memory that is kept between calls.
struct FrameVotesMemory {
  std::vector<LinearMap> maps;
  std::vector<std::uint32_t> rows;  // matches with a map
  DistinctMatches distinct;
  PairGraph graph;
  std::vector<float> errors, value;         // of the neighbours of a match; per distinct match
  std::vector<std::uint32_t> parent;        // of the clusters, by distinct match
  std::vector<std::uint32_t> members;       // distinct right points, by root
  std::vector<std::uint64_t> right_points;  // root and right point of the distinct matches
  std::vector<float> right_x, right_y;
  PointGroups right;
  std::vector<std::uint32_t> clusters;  // accepted ones, by distinct match
  ClusterNumbers numbers;
};

/// exp(-t), at most 3e-4 off, in a form that is vectorised and the same on every machine.
float decay(float t) {
  constexpr int kSquarings = 10;
  float value = std::max(0.0F, 1 - t / (1 << kSquarings));
  for (int k = 0; k < kSquarings; ++k) value *= value;
  return value;
}

/// Writes the density of every match to work.value, relative to the largest one. @return the largest one
float findDensities(float sigma, FrameVotesMemory& work) {
  const std::size_t degree = work.graph.degree();
  work.errors.resize(degree);
  float* const errors = work.errors.data();
  const float scale = 1 / (sigma * sigma);
  float largest = 0;
  for (std::size_t i = 0; i < work.graph.size(); ++i) {
    work.graph.errors(i, errors);
    for (std::size_t k = 0; k < degree; ++k) errors[k] = decay(errors[k] * errors[k] * scale);
    float sum = 0;
    for (std::size_t k = 0; k < degree; ++k) sum += errors[k];
    work.value[i] = degree > 0 ? sum / static_cast<float>(degree) : 0;
    largest = std::max(largest, work.value[i]);
  }
  if (largest > 0) {
    for (float& value : work.value) value /= largest;
  }
  return largest;
}

std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Joins matches that err by at most `cut`, and writes the number of distinct right points of the cluster of
/// every match to work.value.
void findClusters(float cut, FrameVotesMemory& work) {
  const std::size_t n = work.graph.size(), degree = work.graph.degree();
  work.errors.resize(degree);
  work.parent.resize(n);
  std::iota(work.parent.begin(), work.parent.end(), 0U);
  for (std::uint32_t i = 0; i < n; ++i) {
    work.graph.errors(i, work.errors.data());
    const std::uint32_t* const neighbours = work.graph.neighbours(i);
    for (std::size_t k = 0; k < degree; ++k) {
      if (!(work.errors[k] <= cut)) continue;
      const std::uint32_t a = rootOf(work.parent, i), b = rootOf(work.parent, neighbours[k]);
      work.parent[std::max(a, b)] = std::min(a, b);
    }
  }
  const PairColumns columns = work.distinct.columns();
  work.right_x.assign(columns.right_x, columns.right_x + n);
  work.right_y.assign(columns.right_y, columns.right_y + n);
  work.right.number(work.right_x, work.right_y, kSamePixel);
  work.right_points.resize(n);
  for (std::uint32_t i = 0; i < n; ++i)
    work.right_points[i] = std::uint64_t{rootOf(work.parent, i)} << 32 | work.right.of[i];
  std::sort(work.right_points.begin(), work.right_points.end());
  work.members.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (i == 0 || work.right_points[i] != work.right_points[i - 1])
      ++work.members[work.right_points[i] >> 32];
  }
  for (std::uint32_t i = 0; i < n; ++i)
    work.value[i] = static_cast<float>(work.members[rootOf(work.parent, i)]);
}

/// Writes the numbers of the clusters of findClusters() that have more members than the threshold.
void fillGroups(double threshold, FrameVotesMemory& work, Selection& result) {
  const auto n = static_cast<std::uint32_t>(work.distinct.size());
  work.clusters.resize(n);
  for (std::uint32_t i = 0; i < n; ++i)
    work.clusters[i] = work.value[i] > threshold ? rootOf(work.parent, i) : ClusterNumbers::kNone;
  work.numbers.assign(work.clusters, work.members);
  result.group.assign(result.mask.size(), -1);
  for (const std::uint32_t row : work.rows)
    result.group[row] = work.numbers[work.clusters[work.distinct.ofRow(row)]];
}

}  // namespace

void FrameVotesOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("rule",
                 {{Rule::kDensity, "density", "Mean agreement with the neighbours"},
                  {Rule::kComponents, "components", "Clusters of matches that agree"}},
                 "What decides: the density of votes, or the size of clusters", &FrameVotesOptions::rule);
  visitor.choice("maps",
                 {{Maps::kFrames, "frames", "From the local affine frames"},
                  {Maps::kTranslation, "translation", "The translation of the match; needs no frames"}},
                 "Local map of a match", &FrameVotesOptions::maps);
  visitor.integer({"k", 1, PairGraph::kMaxNeighbours, "-", "Neighbours of a match"}, &FrameVotesOptions::k);
  visitor.number({"sigma", 0.01, 100, "%",
                  "Density: error at which a vote falls to 1/e, in percent of the right image's diagonal"},
                 &FrameVotesOptions::sigma);
  visitor.number(
      {"share", 0, 1, "-",
       "Density: matches above this share of the largest density are selected; 0 = threshold by Otsu"},
      &FrameVotesOptions::share);
  visitor.number({"cut", 0, 1000, "px", "Components: matches that err by at most this are joined"},
                 &FrameVotesOptions::cut);
  visitor.integer(
      {"min_members", 1, 1000000, "-", "Components: a cluster needs at least as many distinct right points"},
      &FrameVotesOptions::min_members);
  visitConfidence(visitor);
}

Presets FrameVotesSelector::presets() const {
  return {{"hviv", {}}, {"acc", {{"rule", "components"}, {"k", "32"}}}};
}

std::string FrameVotesSelector::missingInput(const Correspondences& matches) const {
  if (matches.empty()) return "";
  if (options_.maps == FrameVotesOptions::Maps::kFrames) {
    const std::string frames = missingFrames(matches, "frame_votes");
    if (!frames.empty()) return frames;
  }
  if (options_.rule == FrameVotesOptions::Rule::kDensity &&
      (matches.right_size.width <= 0 || matches.right_size.height <= 0))
    return "frame_votes needs the size of the right image";
  return "";
}

void FrameVotesSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  FrameVotesMemory& work = workspace.part<FrameVotesMemory>();
  if (options_.maps == FrameVotesOptions::Maps::kFrames) {
    findFrameMaps(matches, work.maps, work.rows);
  } else {
    work.maps.assign(n, LinearMap{1, 0, 0, 1});
    work.rows.resize(n);
    std::iota(work.rows.begin(), work.rows.end(), 0U);
  }
  if (endsAtFrames(matches, work.rows.size(), result)) return;
  work.distinct.assign(matches, work.maps, work.rows);
  work.graph.build(work.distinct.columns(), work.distinct.size(), options_.k);
  work.value.assign(work.distinct.size(), 0);
  double threshold = 0;
  bool any = false;
  if (options_.rule == FrameVotesOptions::Rule::kDensity) {
    const double diagonal = std::hypot(matches.right_size.width, matches.right_size.height);
    any = findDensities(static_cast<float>(options_.sigma / 100 * diagonal), work) > 0;
    threshold = options_.share;
    if (any && options_.share == 0) {
      std::vector<double> values;
      values.reserve(work.rows.size());
      for (const std::uint32_t row : work.rows) values.push_back(work.value[work.distinct.ofRow(row)]);
      threshold = otsuThreshold(values, 0, 1, kOtsuBins).value_or(0);
    }
  } else {
    findClusters(static_cast<float>(options_.cut), work);
    threshold = options_.min_members - 0.5;
    any = *std::max_element(work.value.begin(), work.value.end()) > threshold;
  }
  if (!any && result.message.empty()) result.message = "no two matches agree";
  if (!any && options_.rule == FrameVotesOptions::Rule::kComponents)
    result.message = "no cluster has " + std::to_string(options_.min_members) + " distinct right points";
  result.iterations = 1;
  result.score.assign(n, std::numeric_limits<float>::quiet_NaN());
  for (const std::uint32_t row : work.rows) {
    const float value = work.value[work.distinct.ofRow(row)];
    result.score[row] = value;
    result.mask[row] = any && value > threshold ? 1 : 0;
  }
  if (any && options_.rule == FrameVotesOptions::Rule::kComponents) fillGroups(threshold, work, result);
}

}  // namespace corrsel::core
