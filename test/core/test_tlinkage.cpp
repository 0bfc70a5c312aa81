#include <gtest/gtest.h>

#include <map>
#include <set>

#include "base/text.h"
#include "corrsel/reference/tlinkage.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Two planes of 120 matches each, side by side, with other homographies, and 120 outliers.
Scene twoPlanes(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  const cv::Matx33d models[] = {cv::Matx33d(0.9, -0.1, 40, 0.1, 0.95, 0, 1e-4, 0, 1),
                                cv::Matx33d(0.7, 0.2, 100, -0.2, 0.7, 200, 0, 1e-4, 1)};
  for (int plane = 0; plane < 2; ++plane) {
    for (int i = 0; i < 120; ++i) {
      const cv::Point2d left = uniformPoint(random, 380, 580) + cv::Point2d(plane * 400, 10);
      addMatch(scene, random, left, projected(models[plane], left.x, left.y) + 0.5 * normalPoint(random),
               true);
    }
  }
  for (int i = 0; i < 120; ++i) {
    const cv::Point2d right = uniformPoint(random, kSceneWidth, kSceneHeight);
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    addMatch(scene, random, left, right, false);
  }
  return scene;
}

TEST(Tlinkage, FindsTwoPlanesAsTwoClusters) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = twoPlanes(seed);
    const Selection s = TlinkageSelector().select(scene.matches);
    const Quality q = quality(s.mask, scene.inlier);
    EXPECT_GT(q.precision, 95);
    EXPECT_GT(q.recall, 95);
    EXPECT_GT(s.iterations, 200);
    // The score is the size of the cluster: no cluster holds matches of both planes.
    std::map<float, std::size_t> sizes;
    for (std::size_t i = 0; i < s.score.size(); ++i) {
      ++sizes[s.score[i]];
      ASSERT_EQ(s.mask[i] == 1, s.score[i] >= 8.0F);
    }
    for (const auto& [size, count] : sizes) {
      EXPECT_EQ(count % std::size_t(size), 0u);
      EXPECT_LE(size, 130.0F);
    }
    EXPECT_GT(sizes.rbegin()->first, 80.0F);
    ASSERT_EQ(s.group.size(), s.mask.size());
    // Groups are numbered by size, and no group holds matches of both planes.
    std::map<std::int32_t, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < s.group.size(); ++i) {
      ASSERT_EQ(s.mask[i] == 1, s.group[i] >= 0);
      if (s.group[i] >= 0) groups[s.group[i]].push_back(i);
    }
    ASSERT_GE(groups.size(), 2u);
    EXPECT_EQ(groups.rbegin()->first, std::int32_t(groups.size()) - 1);
    std::size_t before = s.group.size();
    for (const auto& [number, members] : groups) {
      EXPECT_LE(members.size(), before);
      before = members.size();
      std::size_t of_second = 0;
      for (const std::size_t i : members) {
        EXPECT_EQ(s.score[i], float(members.size()));
        of_second += i >= 120 && i < 240;
      }
      EXPECT_TRUE(number > 1 || 10 * of_second < members.size() || 10 * of_second > 9 * members.size());
    }
  }
}

/// Two bodies of 120 points at random depths, side by side, that move in different ways, and 60 wrong
/// matches.
Scene twoMotions(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  const cv::Matx33d camera(700, 0, 400, 0, 700, 300, 0, 0, 1);
  for (int body = 0; body < 2; ++body) {
    const double angle = body == 0 ? 0.1 : -0.15;
    const cv::Matx33d rotation(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                               std::cos(angle));
    const cv::Vec3d shift = body == 0 ? cv::Vec3d(-1.0, 0.15, 0.2) : cv::Vec3d(0.3, -0.9, 0.1);
    for (int i = 0; i < 120; ++i) {
      const cv::Point2d left = uniformPoint(random, 380, 580) + cv::Point2d(body * 400, 10);
      const cv::Vec3d point = camera.inv() * cv::Vec3d(left.x, left.y, 1) * random.uniform(4, 12);
      const cv::Vec3d seen = camera * (rotation * point + shift);
      const cv::Point2d right(seen[0] / seen[2], seen[1] / seen[2]);
      addMatch(scene, random, left, right + 0.3 * normalPoint(random), true);
    }
  }
  for (int i = 0; i < 60; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    addMatch(scene, random, left, uniformPoint(random, kSceneWidth, kSceneHeight), false);
  }
  return scene;
}

TEST(Tlinkage, FindsTwoMotionsAsTwoClusters) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = twoMotions(seed);
    const Selection s = createSelector("tlinkage:motions")->select(scene.matches);
    const Quality q = quality(s.mask, scene.inlier);
    EXPECT_GT(q.precision, 85) << seed;
    EXPECT_GT(q.recall, 95) << seed;
    std::size_t of[2][2] = {};  // body, group
    for (std::size_t i = 0; i < 240; ++i) {
      if (s.group[i] == 0 || s.group[i] == 1) ++of[i / 120][s.group[i]];
    }
    const int first = of[0][0] > of[0][1] ? 0 : 1;
    EXPECT_GE(of[0][first], 100u) << seed;
    EXPECT_GE(of[1][1 - first], 100u) << seed;
    EXPECT_LE(of[0][1 - first] + of[1][first], 10u) << seed;
    // No homography explains points at random depths.
    EXPECT_LT(quality(createSelector("tlinkage")->select(scene.matches).mask, scene.inlier).recall, 80)
        << seed;
  }
}

TEST(Tlinkage, NamesWhatAFundamentalMatrixNeeds) {
  const Scene scene = twoMotions(4);
  const auto tlinkage = createSelector("tlinkage:motions");
  std::vector<std::uint32_t> rows(7);
  std::iota(rows.begin(), rows.end(), 0U);
  EXPECT_EQ(tlinkage->select(scene.matches.subset(rows)).message, "7 distinct matches, tlinkage needs 8");
  Correspondences m = scene.matches;
  for (std::size_t i = 0; i < m.size(); ++i) m.left_y[i] = 2 * m.left_x[i];
  const Selection line = tlinkage->select(m);
  EXPECT_EQ(line.status, Status::kDegenerate);
  EXPECT_EQ(line.message, "no seven neighbouring matches determine a fundamental matrix");
}

TEST(Tlinkage, JLinkageHasHardPreferences) {
  const Scene scene = twoPlanes(4);
  const Quality q = quality(createSelector("tlinkage:jlinkage")->select(scene.matches).mask, scene.inlier);
  EXPECT_GT(q.precision, 95);
  EXPECT_GT(q.recall, 90);
}

/// T-Linkage on the dense preference matrix, as it is defined. @return the sizes of the clusters
std::vector<std::size_t> clustersByDefinition(std::vector<std::vector<double>> p) {
  std::vector<std::size_t> size(p.size(), 1), cluster(p.size());
  std::iota(cluster.begin(), cluster.end(), 0U);
  const auto distance = [&p](std::size_t i, std::size_t j) {
    double dot = 0, a = 0, b = 0;
    for (std::size_t h = 0; h < p[i].size(); ++h) {
      dot += p[i][h] * p[j][h];
      a += p[i][h] * p[i][h];
      b += p[j][h] * p[j][h];
    }
    return dot > 0 ? 1 - dot / (a + b - dot) : 1.0;
  };
  while (true) {
    double least = 1;
    std::size_t a = 0, b = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      for (std::size_t j = i + 1; j < p.size(); ++j) {
        if (size[i] == 0 || size[j] == 0 || !(distance(i, j) < least)) continue;
        least = distance(i, j);
        a = i;
        b = j;
      }
    }
    if (least >= 1) break;
    for (std::size_t h = 0; h < p[a].size(); ++h) p[a][h] = std::min(p[a][h], p[b][h]);
    size[a] += size[b];
    size[b] = 0;
    for (std::size_t& c : cluster) c = c == b ? a : c;
  }
  for (std::size_t& c : cluster) c = size[c];
  return cluster;
}

TEST(Tlinkage, MergesAsDefined) {
  // Matches on a lattice under two translations. Any homography through four matches of one of them is this
  // translation up to rounding, so that preferences are known: for a large scale, 1 or nearly 0.
  Correspondences m;
  Random random(3);
  for (int i = 0; i < 30; ++i) {
    const cv::Point2f left = uniformPoint(random, 200, 200);
    const bool second = i >= 18;
    m.add(second ? left + cv::Point2f(5000, 0) : left,
          left + (second ? cv::Point2f(-4000, 3000) : cv::Point2f(7, 9)));
  }
  TlinkageOptions options;
  options.tau = 1;
  const Selection s = TlinkageSelector(options).select(m);
  std::vector<std::vector<double>> preferences(30, std::vector<double>(60, 0));
  for (std::size_t i = 0; i < 30; ++i) {
    for (std::size_t h = 0; h < 60; ++h) preferences[i][h] = (i >= 18) == (h >= 30) ? 1 : 0;
  }
  const std::vector<std::size_t> sizes = clustersByDefinition(preferences);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(s.score[i], float(sizes[i])) << i;
    EXPECT_EQ(sizes[i], i < 18 ? 18u : 12u);
  }
  EXPECT_EQ(s.iterations, 28);
}

TEST(Tlinkage, CountsEqualMatchesOnce) {
  const Scene scene = homographyScene({7, 1.0, 0.0, 5});
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < 70; ++i) rows.push_back(i % 7);
  const Selection s = TlinkageSelector().select(scene.matches.subset(rows));
  EXPECT_EQ(s.n_selected, 0u);
  EXPECT_TRUE(s.group.empty());
  EXPECT_EQ(createSelector("tlinkage", {{"min_cluster", "7"}})->select(scene.matches.subset(rows)).n_selected,
            70u);
}

TEST(Tlinkage, RefusesManyMatches) {
  const Correspondences m = homographyScene({600, 0.5, 0.5, 6}).matches;
  const Selection s = createSelector("tlinkage", {{"max_matches", "599"}})->select(m);
  EXPECT_EQ(s.status, Status::kTooLarge);
  EXPECT_EQ(s.message,
            "600 distinct matches, more than max_matches = 599; preselect matches, or use another selector");
  EXPECT_EQ(s.n_selected, 0u);
  EXPECT_EQ(createSelector("tlinkage", {{"max_matches", "600"}})->select(m).status, Status::kOk);
}

TEST(Tlinkage, StopsAtTheTimeLimit) {
  const Correspondences m = homographyScene({300, 0.6, 0.5, 7}).matches;
  std::set<Status> seen;
  for (double seconds = 0.5; seen.count(Status::kOk) == 0; seconds += 5) {
    ASSERT_LT(seconds, 1000);
    const TickingClock clock(1);
    const Selection s = createSelector("tlinkage", {{"max_seconds", formatNumber(seconds)}})->select(m);
    EXPECT_LE(clock.looks(), seconds + 3);
    if (s.status != Status::kOk) {
      EXPECT_EQ(s.message, "stopped after " + std::to_string(s.iterations) +
                               " mergers, max_seconds = " + formatNumber(seconds));
    }
    seen.insert(s.status);
  }
  EXPECT_EQ(seen, (std::set<Status>{Status::kOk, Status::kTooLarge, Status::kTimeLimit}));
}

TEST(Tlinkage, DecidesDegenerateInput) {
  const Scene scene = homographyScene({60, 1.0, 0.0, 8});
  const TlinkageSelector tlinkage;
  const Selection few = tlinkage.select(scene.matches.subset({0, 1, 2, 3, 3}));
  EXPECT_EQ(few.status, Status::kTooFew);
  EXPECT_EQ(few.message, "4 distinct matches, tlinkage needs 5");
  Correspondences m = scene.matches;
  for (std::size_t i = 0; i < 60; ++i) m.left_y[i] = 2 * m.left_x[i];
  const Selection line = tlinkage.select(m);
  EXPECT_EQ(line.status, Status::kDegenerate);
  EXPECT_EQ(line.message, "no four neighbouring matches determine a homography");
  m.left_x.assign(60, 5);
  m.left_y.assign(60, 6);
  EXPECT_EQ(tlinkage.select(m).status, Status::kDegenerate);
  m = scene.matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  EXPECT_EQ(tlinkage.select(m).n_selected, 60u);
}

TEST(Tlinkage, ReachesItsMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  double sum = 0;
  for (const char* seed : {"0", "1", "2", "3"}) {
    const double f = adelaideMeans("tlinkage", {{"seed", seed}}).f;
    EXPECT_NEAR(f, 97.8, 0.4) << seed;
    sum += f;
  }
  EXPECT_GE(sum / 4, 97.5);
}

TEST(Tlinkage, FundamentalMatricesReachTheirMeanOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("tlinkage:motions");
  EXPECT_NEAR(q.precision, 96.3, 0.5);
  EXPECT_NEAR(q.recall, 96.2, 0.7);
  EXPECT_NEAR(q.f, 96.0, 0.5);
}

}  // namespace
}  // namespace corrsel::core
