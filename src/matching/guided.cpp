#include "corrsel/matching/guided.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "matching/nearest.h"
#include "matching/predicted_areas.h"
#include "matching/putative.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

constexpr double kSigmas = 3;  // of the rotation, within the area
constexpr std::size_t kTested = 150;
constexpr double kRatio = 0.8;
constexpr std::size_t kBackground = 128;

/// Left features that pass the ratio test, and the right features they are nearest to.
struct TestedMatches {
  std::vector<std::uint32_t> left, right;
  std::size_t compared = 0;  ///< left features
};

/// What is within the reach of a predicted place.
struct Reach {
  double inner = 0;  ///< half the width of the area, px
  double outer = 0;  ///< within which the matches must not spread beyond it, px
};

/// The strongest left features with a predicted place, one per cell of a grid; the first of equals.
std::vector<std::uint32_t> strongest(const Features& left, const PredictedAreas& areas) {
  std::vector<std::uint32_t> inside;
  cv::Point2f low(INFINITY, INFINITY), high(-INFINITY, -INFINITY);
  for (std::uint32_t i = 0; i < left.keypoints.size(); ++i) {
    if (!areas.isInside(i)) continue;
    const cv::Point2f& place = left.keypoints[i].pt;
    low = {std::min(low.x, place.x), std::min(low.y, place.y)};
    high = {std::max(high.x, place.x), std::max(high.y, place.y)};
    inside.push_back(i);
  }
  if (inside.size() <= kTested) return inside;
  const double width = std::max(1.F, high.x - low.x), height = std::max(1.F, high.y - low.y);
  const CellGrid grid = CellGrid::covering(low.x, low.y, width, height, std::sqrt(width * height / kTested));
  std::vector<std::uint32_t> best(grid.cells(), Neighbours::kNone);
  for (const std::uint32_t i : inside) {
    const cv::KeyPoint& keypoint = left.keypoints[i];
    std::uint32_t& of_cell = best[grid.cell(keypoint.pt.x, keypoint.pt.y)];
    if (of_cell == Neighbours::kNone || keypoint.response > left.keypoints[of_cell].response) of_cell = i;
  }
  best.erase(std::remove(best.begin(), best.end(), Neighbours::kNone), best.end());
  return best;
}

/// Compares some left features with all right ones.
TestedMatches compareWithAll(const Features& left, const Features& right,
                             const std::vector<std::uint32_t>& rows, int threads) {
  cv::Mat descriptors(static_cast<int>(rows.size()), left.descriptors.cols, left.descriptors.type());
  for (std::size_t i = 0; i < rows.size(); ++i)
    left.descriptors.row(static_cast<int>(rows[i])).copyTo(descriptors.row(static_cast<int>(i)));
  NeighbourSearch search;
  search.threads = threads;
  search.ratio = kRatio;
  const Neighbours nearest = findNeighbours(descriptors, right.descriptors, search);
  TestedMatches result;
  result.compared = rows.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (nearest.train[i] == Neighbours::kNone) continue;
    result.left.push_back(rows[i]);
    result.right.push_back(nearest.train[i]);
  }
  return result;
}

/// Right features whose distances stand for those of wrong ones.
std::vector<std::uint32_t> evenlySpread(std::size_t size) {
  const std::size_t count = std::min(size, kBackground);
  std::vector<std::uint32_t> rows;
  for (std::size_t k = 0; k < count; ++k) rows.push_back(static_cast<std::uint32_t>(k * size / count));
  return rows;
}

/// How many tested matches are in an area, and how many chance puts there.
struct Agreement {
  double count = 0;
  double chance = 0;  ///< of one match
};

/// The agreement with both areas. The chance is the share of evenly spread right features.
std::array<Agreement, 2> agreementOf(const TestedMatches& tested, const PredictedAreas& areas,
                                     const Reach& reach, std::size_t right_size) {
  std::vector<std::uint32_t> rights = evenlySpread(right_size);
  const auto spread = static_cast<double>(rights.size());
  rights.push_back(0);
  std::array<Agreement, 2> result;
  std::vector<double> distances;
  for (std::size_t i = 0; i < tested.left.size(); ++i) {
    rights.back() = tested.right[i];
    areas.distances(tested.left[i], reach.outer, rights, distances);
    for (std::size_t area = 0; area < 2; ++area) {
      const double limit = area == 0 ? reach.inner : reach.outer;
      if (distances.back() <= limit) ++result[area].count;
      const auto inside =
          std::count_if(distances.begin(), distances.end() - 1, [&](double d) { return d <= limit; });
      result[area].chance += static_cast<double>(inside) / (spread * static_cast<double>(tested.left.size()));
    }
  }
  return result;
}

/// What tested matches show about a guess. The answer is kNone, too, where it is right but not close enough.
GuessVerdict judge(const TestedMatches& tested, const PredictedAreas& areas, const Reach& reach,
                   std::size_t right_size) {
  constexpr std::size_t kMinTested = 16, kMinShare = 10;
  constexpr double kMaxExcess = 0.15;
  const std::size_t n = tested.left.size();
  if (n < std::max(kMinTested, tested.compared / kMinShare)) return GuessVerdict::kNone;
  const auto [inner, outer] = agreementOf(tested, areas, reach, right_size);
  const auto isBeyondChance = [&, chance = inner.chance](double count) {
    return isSignificant(-log10BinomialTail(n, static_cast<std::size_t>(count), chance));
  };
  const auto all = static_cast<double>(n);
  if (!isBeyondChance(all)) return GuessVerdict::kNone;
  if (!isBeyondChance(inner.count)) return GuessVerdict::kContradicted;
  if (2 * inner.count < all) return GuessVerdict::kNone;
  const double expected = (all - inner.count) * (outer.chance - inner.chance);
  const double excess = outer.count - inner.count - expected;
  const bool spreads = excess > kMaxExcess * inner.count;
  return spreads ? GuessVerdict::kNone : GuessVerdict::kConfirmed;
}

Correspondences matchAmong(const Features& left, const Features& right,
                           const std::vector<CandidateGroup>& groups, const MatchOptions& options,
                           int threads) {
  NeighbourSearch search;
  search.threads = threads;
  search.nearest_query = options.mutual;
  search.second_radius = options.second_distance_radius;
  search.train_keypoints = &right.keypoints;
  const Neighbours nearest = findNeighboursAmong(left.descriptors, right.descriptors, groups,
                                                 evenlySpread(right.keypoints.size()), search);
  return putativeMatches(left, right, nearest, options.mutual);
}

}  // namespace

void GuidedOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"radius", 1, 1000, "0.001 of the diagonal",
                  "Guided matching: radius of the area around the place that the rotation predicts"},
                 &GuidedOptions::radius);
  visitor.number({"band", 1, 1000, "0.001 of the diagonal",
                  "Guided matching: half the width of the band along the epipolar line of a translation"},
                 &GuidedOptions::band);
}

GuidedMatches matchGuided(const Features& left, const Features& right, const Camera& left_camera,
                          const Camera& right_camera, const MotionGuess& guess, const MatchOptions& options,
                          const GuidedOptions& guided, int threads) {
  options.check();
  guided.check();
  left_camera.check();
  right_camera.check();
  guess.check();
  if (left.keypoints.empty() || right.keypoints.empty())
    return {matchFeatures(left, right, options), GuessVerdict::kNone};
  checkDescriptors(left, right);
  constexpr double kUnits = 1.25;  // lengthUnit() is 0.8 thousandths of the diagonal
  PredictedAreas areas(left, right, left_camera, right_camera, guess, threads);
  const std::vector<std::uint32_t> rows = strongest(left, areas);
  GuessVerdict verdict = GuessVerdict::kNone;
  const double uncertainty = kSigmas * areas.sigma();
  const double radius = guided.radius * kUnits * areas.unit() + uncertainty;
  Reach reach = {radius, 2 * radius};
  if (!rows.empty()) {
    const TestedMatches tested = compareWithAll(left, right, rows, threads);
    if (guess.translation) {
      const Reach band = {guided.band * kUnits * areas.unit() + uncertainty, radius};
      verdict = judge(tested, areas, band, right.keypoints.size());
      if (verdict == GuessVerdict::kConfirmed)
        reach = band;
      else
        areas.forgetTranslation();
    }
    if (!areas.knowsTranslation()) verdict = judge(tested, areas, reach, right.keypoints.size());
  }
  if (verdict != GuessVerdict::kConfirmed) return {matchFeatures(left, right, options, threads), verdict};
  return {matchAmong(left, right, areas.groups(reach.inner, threads), options, threads), verdict};
}

}  // namespace corrsel::core
