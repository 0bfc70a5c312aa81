#include <gtest/gtest.h>

#include <map>
#include <set>

#include "corrsel/selectors/ransac.h"
#include "geometry/residual.h"
#include "search/support.h"
#include "search/verifier.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Matches with the given points in pixels.
NormalizedMatches matchesOf(const std::vector<std::pair<cv::Point2f, cv::Point2f>>& points) {
  Correspondences matches;
  for (const auto& [left, right] : points) matches.add(left, right);
  return normalizeMatches(matches);
}

/// Matches whose points lie on a grid of 8 x 8 places in both images, so that nearly all share a point.
Correspondences crowded(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Correspondences m;
  for (std::size_t i = 0; i < n; ++i) {
    const auto place = [&random] { return 50.0F * static_cast<float>(random.index(8)); };
    const float left_y = place(), left_x = place(), right_y = place(), right_x = place();
    m.add({left_x, left_y}, {right_x, right_y});
  }
  return m;
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> rows) {
  std::sort(rows.begin(), rows.end());
  return rows;
}

TEST(DistinctSupport, PointsAreEqualIfTheyAreEqualAfterRounding) {
  // The left points differ by 0.2 px and by 3 px; the last right point is that of the first match.
  const NormalizedMatches m = matchesOf({{{100, 100}, {10, 10}},
                                         {{100.2F, 100}, {500, 20}},
                                         {{103, 100}, {50, 300}},
                                         {{400, 200}, {80, 400}},
                                         {{700, 500}, {10, 10}}});
  DistinctSupport support;
  support.group(m, 2.5 * m.scale);
  EXPECT_EQ(sorted(support.shared()), (std::vector<std::uint32_t>{0, 1, 4}));
  // With small cells only the equal points remain together.
  support.group(m, 1e-3 * m.scale);
  EXPECT_EQ(sorted(support.shared()), (std::vector<std::uint32_t>{0, 4}));
  // Cells that are too small to be numbered: equal coordinates.
  support.group(m, 1e-30);
  EXPECT_EQ(sorted(support.shared()), (std::vector<std::uint32_t>{0, 4}));
}

TEST(DistinctSupport, TheSmallestErrorOfEachPointCounts) {
  // Matches 0, 1, 2 share a right point; 2 and 3 share a left point.
  const NormalizedMatches m = matchesOf({{{0, 0}, {9, 9}},
                                         {{50, 0}, {9, 9}},
                                         {{90, 30}, {9, 9}},
                                         {{90, 30}, {300, 40}},
                                         {{20, 200}, {70, 70}}});
  DistinctSupport support;
  support.group(m, m.scale);
  EXPECT_EQ(sorted(support.shared()), (std::vector<std::uint32_t>{0, 1, 2, 3}));
  const auto count = [&support](const std::vector<float>& errors) {
    return support.countInliers(errors.data(), 1.0F);
  };
  EXPECT_EQ(count({0.1F, 0.2F, 0.3F, 0.4F, 0.5F}), 3u);  // 0, 3, 4
  EXPECT_EQ(count({0.3F, 0.2F, 0.1F, 0.4F, 0.5F}), 2u);  // 2 wins its right and its left point
  EXPECT_EQ(count({0.3F, 0.2F, 0.1F, 0.4F, 1.1F}), 1u);
  EXPECT_EQ(count({2, 2, 2, 0.4F, 0.5F}), 2u);
  EXPECT_EQ(count({2, 2, 2, 2, 2}), 0u);
  EXPECT_EQ(count({INFINITY, 0.2F, NAN, 0.4F, 2}), 2u);
}

TEST(DistinctSupport, InliersThatCountAreOneToOneAndAsManyAsAPlainSearchFinds) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const NormalizedMatches m = normalizeMatches(crowded(300, seed));
    DistinctSupport support;
    support.group(m, m.scale);
    Random random(seed);
    std::vector<float> errors(m.size());
    for (float& error : errors) error = static_cast<float>(random.uniform(0, 2));
    // The same definition by maps: the best of each right point, then the best of each left point.
    using Point = std::pair<float, float>;
    // No two errors are equal at the resolution of the score.
    std::map<Point, std::size_t> by_right;
    for (std::size_t i = 0; i < m.size(); ++i) {
      if (errors[i] > 1) continue;
      const auto [entry, fresh] = by_right.insert({{m.right_x[i], m.right_y[i]}, i});
      if (!fresh && errors[i] < errors[entry->second]) entry->second = i;
    }
    std::set<Point> left;
    for (const auto& [point, i] : by_right) left.insert({m.left_x[i], m.left_y[i]});
    EXPECT_EQ(support.countInliers(errors.data(), 1.0F), left.size());
    EXPECT_LE(left.size(), 64u);
  }
}

TEST(DistinctSupport, VerifierGivesUncountedInliersTheCostOfOutliers) {
  for (const Residual residual :
       {Residual::kTransfer, Residual::kSymmetricTransfer, Residual::kSmallerTransfer, Residual::kSampson}) {
    for (const bool msac : {true, false}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(residual)) + (msac ? " msac" : " count"));
      const NormalizedMatches m = normalizeMatches(crowded(600, 3));
      DistinctSupport support;
      support.group(m, m.scale);
      const double threshold = 60 * m.scale;
      const Verifier plain(m, residual, threshold, msac), distinct(m, residual, threshold, msac, &support);
      const cv::Matx33d model = residual == Residual::kSampson
                                    ? cv::Matx33d(0, 0, 0.1, 0, 0, -0.7, 0.1, 0.7, 0)
                                    : cv::Matx33d(0.5, 0.1, 0, -0.1, 0.6, 0, 0, 0, 0.6);
      constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();
      const ModelScore all = plain.score(model, kNoLimit), once = distinct.score(model, kNoLimit);
      std::vector<float> errors(m.size());
      modelErrors(residual, model, m, 0, m.size(), errors.data());
      EXPECT_EQ(all.surplus, 0u);
      EXPECT_EQ(once.inliers, all.inliers);
      const std::size_t counted = support.countInliers(errors.data(), plain.squaredThreshold());
      EXPECT_EQ(once.inliers - once.surplus, counted);
      EXPECT_GT(once.surplus, 3u);
      EXPECT_GT(counted, 10u);
      const auto lost = static_cast<std::int64_t>(once.surplus);
      EXPECT_GT(once.cost, all.cost);
      EXPECT_LE(once.cost, all.cost + lost * ScoreRule::kOutlierCost);
      if (!msac) {
        EXPECT_EQ(once.cost, all.cost + lost * ScoreRule::kOutlierCost);
      }
      // The limit applies to the cost of the distinct inliers.
      EXPECT_TRUE(distinct.score(model, once.cost).rejected);
      EXPECT_FALSE(distinct.score(model, once.cost + 1).rejected);
      Candidate best;
      EXPECT_TRUE(distinct.improve(model, best));
      EXPECT_EQ(best.cost, once.cost);
      EXPECT_EQ(best.inliers, once.inliers);
      EXPECT_EQ(best.distinct, counted);
    }
  }
}

/// 50 of 200 matches agree with the identity, and 150 end in one of five neighbouring places.
TEST(DistinctSupport, ManyMatchesThatEndInOnePlaceDoNotOutvoteTheRightModel) {
  int plain = 0, once = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Correspondences m;
    for (int i = 0; i < 200; ++i) {
      const cv::Point2d left = uniformPoint(random, 640, 480);
      const cv::Point2d places[5] = {{320, 240}, {322, 242}, {318, 242}, {322, 238}, {318, 238}};
      const cv::Point2d right = i < 50 ? left + normalPoint(random) : places[i % 5];
      m.add(cv::Point2f(left), cv::Point2f(right));
    }
    for (const bool one_to_one : {false, true}) {
      RansacOptions options;
      options.max_iterations = 20000;
      options.one_to_one = one_to_one;
      const Selection s = RansacSelector(options).select(m);
      double worst = 0;
      for (const cv::Point2d corner : {cv::Point2d(0, 0), {640, 0}, {0, 480}, {640, 480}})
        worst = std::max(worst, cv::norm(projected(s.model, corner.x, corner.y) - corner));
      (one_to_one ? once : plain) += worst < 15 ? 1 : 0;
    }
  }
  EXPECT_EQ(plain, 0);
  EXPECT_EQ(once, 20);
}

TEST(DistinctSupport, MaskHoldsAllMatchesWithinTheThreshold) {
  Scene scene = homographyScene({400, 0.5, 0.5, 1});
  Correspondences& m = scene.matches;
  // Each of the first 100 inliers occurs twice.
  for (std::size_t i = 0; i < 100; ++i) {
    m.left_x[i + 100] = m.left_x[i];
    m.left_y[i + 100] = m.left_y[i];
    m.right_x[i + 100] = m.right_x[i];
    m.right_y[i + 100] = m.right_y[i];
  }
  RansacOptions options;
  options.one_to_one = true;
  const Selection s = RansacSelector(options).select(m);
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(quality(s.mask, scene.inlier).recall, 100);
}

TEST(DistinctSupport, PointsThatAreAllEqualSupportNothing) {
  Correspondences m = homographyScene({100, 0.5, 0.5, 1}).matches;
  std::fill(m.right_x.begin(), m.right_x.end(), 300.2F);
  std::fill(m.right_y.begin(), m.right_y.end(), 200.4F);
  for (std::size_t i = 0; i < 100; i += 2) m.right_x[i] += 0.0625F;
  RansacOptions options;
  options.one_to_one = true;
  const Selection s = RansacSelector(options).select(m);
  EXPECT_EQ(s.status, Status::kDegenerate);
  EXPECT_EQ(s.n_selected, 0u);
}

}  // namespace
}  // namespace corrsel::core
