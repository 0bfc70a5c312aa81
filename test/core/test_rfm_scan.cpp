#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "adelaide_counts.h"
#include "corrsel/reference/rfm_scan.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;
using Point = std::array<float, 6>;

/// All values of the definition, between all pairs of matches. @pre the matches are sorted by left x
class Definition {
 public:
  Definition(const Correspondences& m, const RfmScanOptions& o) : n_(m.size()), factor_(n_, 1) {
    const auto point = [&m](std::size_t left, std::size_t right) {
      return Point{m.left_x[left],
                   m.left_y[left],
                   m.right_x[right],
                   m.right_y[right],
                   m.right_x[right] - m.left_x[left],
                   m.right_y[right] - m.left_y[left]};
    };
    for (std::size_t i = 0; i < n_; ++i) points_.push_back(point(i, i));
    for (std::size_t k = 0; k < 20; ++k) points_.push_back(point(k * n_ / 20, (k * n_ / 20 + n_ / 2) % n_));
    for (std::size_t c = 0; c < 6; ++c) {
      const auto [low, high] = std::minmax_element(
          points_.begin(), points_.end(), [c](const Point& a, const Point& b) { return a[c] < b[c]; });
      const float least = (*low)[c], range = (*high)[c] - least;
      for (Point& p : points_) p[c] = range > 0 ? (p[c] - least) / range : 0;
    }
    const auto share = int(std::lround(o.min_points_share * double(n_)));
    min_members_ = std::min(n_, std::size_t(std::clamp(share, o.min_points, o.max_points)));
    gamma_ = float(o.gamma);
    findClusters(float(o.first_epsilon));
    for (std::size_t i = 0; i < n_; ++i) factor_[i] = cluster[i] < 0 ? 100 : 1;
    findClusters(float(o.second_epsilon));
  }

  std::vector<int> cluster;  // of every match; -1 = none

 private:
  float distance(std::size_t i, std::size_t j) const {
    const auto apart = [&](std::size_t c) {
      const float x = points_[i][c] - points_[j][c], y = points_[i][c + 1] - points_[j][c + 1];
      return std::sqrt(x * x + y * y);
    };
    const float left = apart(0), right = apart(2);
    return factor_[j] * (left + right + (1 + gamma_ * std::exp(-std::min(left, right))) * apart(4));
  }

  void findClusters(float epsilon) {
    std::vector<float> reach;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      std::vector<float> distances;
      for (std::size_t j = 0; j < n_; ++j) distances.push_back(distance(i, j));
      std::sort(distances.begin(), distances.end());
      reach.push_back(distances[min_members_ - 1]);
    }
    const float low = *std::min_element(reach.begin(), reach.begin() + std::ptrdiff_t(n_));
    const float limit = low + epsilon * (*std::max_element(reach.begin(), reach.end()) - low);
    cluster.assign(n_, -1);
    int clusters = 0;
    for (std::size_t seed = 0; seed < n_; ++seed) {
      if (cluster[seed] >= 0 || reach[seed] > limit) continue;
      std::vector<std::size_t> open = {seed};
      cluster[seed] = clusters;
      while (!open.empty()) {
        const std::size_t i = open.back();
        open.pop_back();
        for (std::size_t j = 0; j < n_; ++j) {
          if (cluster[j] >= 0 || reach[j] > limit || std::min(distance(i, j), distance(j, i)) > limit)
            continue;
          cluster[j] = clusters;
          open.push_back(j);
        }
      }
      ++clusters;
    }
    for (std::size_t j = 0; j < n_; ++j) {
      if (cluster[j] >= 0) continue;
      float least = limit;
      for (std::size_t i = 0; i < n_; ++i) {
        if (reach[i] > limit || distance(i, j) > least) continue;
        least = distance(i, j);
        cluster[j] = cluster[i];
      }
    }
  }

  std::size_t n_, min_members_ = 0;
  float gamma_ = 0;
  std::vector<float> factor_;
  std::vector<Point> points_;
};

Correspondences sortedByLeftX(const Correspondences& m) {
  std::vector<std::uint32_t> rows(m.size());
  std::iota(rows.begin(), rows.end(), 0U);
  std::sort(rows.begin(), rows.end(),
            [&m](std::uint32_t a, std::uint32_t b) { return m.left_x[a] < m.left_x[b]; });
  return m.subset(rows);
}

TEST(RfmScan, FollowsTheDefinition) {
  std::size_t max_groups = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const SceneOptions options{100 + 80 * seed, 0.2 + 0.1 * double(seed), 0.5 * double(seed), seed};
    const Correspondences m =
        sortedByLeftX((seed % 2 ? homographyScene(options) : stereoScene(options)).matches);
    RfmScanOptions scan;
    if (seed > 4) {
      scan.gamma = 5;
      scan.max_points = 12;
      scan.first_epsilon = 0.04;
      scan.second_epsilon = 0.03;
    }
    const Selection s = RfmScanSelector(scan).select(m);
    const std::vector<int> expected = Definition(m, scan).cluster;
    // The same partition: groups and clusters correspond one to one.
    std::set<std::pair<int, int>> pairs;
    std::set<int> clusters;
    for (std::size_t i = 0; i < m.size(); ++i) {
      EXPECT_EQ(s.mask[i] != 0, expected[i] >= 0) << seed << " " << i;
      pairs.insert({s.group[i], expected[i]});
      clusters.insert(expected[i]);
    }
    EXPECT_EQ(pairs.size(), clusters.size()) << seed;
    EXPECT_EQ(std::set<int>(s.group.begin(), s.group.end()).size(), clusters.size()) << seed;
    EXPECT_GT(s.n_selected, 10u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
    max_groups = std::max(max_groups, clusters.size());
  }
  EXPECT_GT(max_groups, 2u);
}

TEST(RfmScan, FindsTwoMotionsAsTwoGroups) {
  Random random(5);
  Scene scene;
  for (int i = 0; i < 900; ++i) {
    const cv::Point2d left = uniformPoint(random, 640, 480);
    const cv::Point2d motion = i < 300 ? cv::Point2d(60, 20) : cv::Point2d(-40, -30);
    if (i < 500) {
      addMatch(scene, random, left, left + motion + 0.5 * normalPoint(random), true);
    } else {
      addMatch(scene, random, left, uniformPoint(random, 640, 480), false);
    }
  }
  const Selection s = createSelector("rfm_scan")->select(scene.matches);
  EXPECT_GT(quality(s.mask, scene.inlier).precision, 95);
  EXPECT_GT(quality(s.mask, scene.inlier).recall, 97);
  std::size_t sizes[2] = {};
  for (std::size_t i = 0; i < 900; ++i) {
    ASSERT_EQ(s.mask[i] != 0, s.group[i] >= 0);
    ASSERT_LE(s.group[i], 1);
    if (s.group[i] >= 0) ++sizes[s.group[i]];
    if (scene.inlier[i] != 0 && s.mask[i] != 0) {
      EXPECT_EQ(s.group[i], scene.matches.right_x[i] > scene.matches.left_x[i] ? 0 : 1) << i;
    }
  }
  EXPECT_GT(sizes[0], sizes[1]);
  for (std::size_t i = 0; i < 900; ++i)
    EXPECT_EQ(s.score[i], s.group[i] < 0 ? 0.0F : float(sizes[s.group[i]]));
  EXPECT_EQ(s.iterations, 2);
}

/// Without outliers, the range of the motions is that of the noise.
TEST(RfmScan, KeepsMatchesThatAreAllRight) {
  for (const std::size_t n : {300, 2000}) {
    Random random(n);
    Correspondences rest, same, affine;
    for (std::size_t i = 0; i < n; ++i) {
      const cv::Point2d left = uniformPoint(random, 640, 480), noise = 0.5 * normalPoint(random);
      rest.add(left, left + noise);
      same.add(left, left);
      affine.add(left, cv::Point2d(0.9 * left.x - 0.1 * left.y + 40, 0.1 * left.x + 0.95 * left.y) + noise);
    }
    const auto selector = createSelector("rfm_scan");
    EXPECT_EQ(selector->select(rest).n_selected, n);
    EXPECT_EQ(selector->select(same).n_selected, n);
    EXPECT_GE(selector->select(affine).n_selected, n - n / 100);
  }
}

TEST(RfmScan, NamesWhatItCannotDecide) {
  const auto selector = createSelector("rfm_scan");
  EXPECT_EQ(selector->select({}).status, Status::kOk);
  EXPECT_EQ(selector->select(homographyScene({5, 1.0, 0.0, 1}).matches).message,
            "5 matches, rfm_scan needs 6");
  Correspondences m = homographyScene({50, 1.0, 0.0, 1}).matches;
  m.right_x.assign(50, 1);
  m.right_y.assign(50, 2);
  EXPECT_EQ(selector->select(m).status, Status::kDegenerate);
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] {
                         createSelector("rfm_scan", {{"min_points", "31"}});
                       }),
                       {"rfm_scan", "min_points = 31", "max_points = 30"}));
}

TEST(RfmScan, EqualMatchesCountEach) {
  Correspondences m = homographyScene({40, 0.0, 0.0, 2}).matches;
  const auto selector = createSelector("rfm_scan");
  const Mask before = selector->select(m).mask;
  const auto alone = std::uint32_t(std::find(before.begin(), before.end(), 0) - before.begin());
  ASSERT_LT(alone, 40u);
  std::vector<std::uint32_t> rows(m.size());
  std::iota(rows.begin(), rows.end(), 0U);
  rows.insert(rows.end(), 4, alone);
  const Selection s = selector->select(m.subset(rows));
  EXPECT_EQ(s.mask[alone], 1);
  EXPECT_GE(s.score[alone], 5.0F);
}

TEST(RfmScan, ReachesTheExpectedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("rfm_scan");
  EXPECT_NEAR(q.precision, 97.5, 0.2);
  EXPECT_NEAR(q.recall, 97.9, 0.2);
  EXPECT_NEAR(q.f, 97.6, 0.2);
  expectCounts("rfm_scan",
               {{"barrsmith", {82, 75}},
                {"biscuit", {146, 146}},
                {"cubechips", {141, 141}},
                {"hartley", {126, 123}},
                {"unionhouse", {79, 78}}},
               1);
}

}  // namespace
}  // namespace corrsel::core
