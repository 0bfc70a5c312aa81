#include <gtest/gtest.h>

#include <map>

#include "corrsel/selectors/laf.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// LAF with its formulas written out, without a noise floor. @pre distinct pixels, points inside the images
std::vector<double> byDefinition(const Correspondences& m, double accept, int rounds) {
  const std::size_t n = m.size();
  const int side = std::clamp(int(std::lround(std::sqrt(double(n)))), 15, 30);
  const int half = int(std::lround(side / 6.0)) - 1;
  const auto range = [](const std::vector<float>& v) {
    const auto [low, high] = std::minmax_element(v.begin(), v.end());
    return std::pair<double, double>(*low, *high);
  };
  const auto [low_x, high_x] = range(m.left_x);
  const auto [low_y, high_y] = range(m.left_y);
  double max_x = 0, max_y = 0;
  for (std::size_t i = 0; i < n; ++i) {
    max_x = std::max(max_x, std::abs(double(m.right_x[i]) - m.left_x[i]));
    max_y = std::max(max_y, std::abs(double(m.right_y[i]) - m.left_y[i]));
  }
  std::vector<cv::Point2d> v(n);
  std::vector<int> row(n), column(n);
  for (std::size_t i = 0; i < n; ++i) {
    v[i] = {(double(m.right_x[i]) - m.left_x[i]) / max_x, (double(m.right_y[i]) - m.left_y[i]) / max_y};
    column[i] = int((0.01 + 0.98 * (m.left_x[i] - low_x) / (high_x - low_x)) * side);
    row[i] = int((0.01 + 0.98 * (m.left_y[i] - low_y) / (high_y - low_y)) * side);
  }
  double norm = 0;
  for (int a = -half; a <= half; ++a) {
    for (int b = -half; b <= half; ++b) norm += std::exp(-std::hypot(a, b));
  }
  const double lambdas[] = {0.8, 0.2, 0.1, 0.05, 0.05};
  std::vector<double> p(n, 1);
  for (int round = 0; round < rounds; ++round) {
    std::map<std::pair<int, int>, std::pair<double, cv::Point2d>> cells;  // number and sum
    for (std::size_t i = 0; i < n; ++i) {
      if (!(p[i] > accept)) continue;
      auto& cell = cells[{row[i], column[i]}];
      cell.first += 1;
      cell.second += v[i];
    }
    std::vector<double> d2(n);
    double close = 0, sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      double weight = 0;
      cv::Point2d motion(0, 0);
      for (int a = -half; a <= half; ++a) {
        for (int b = -half; b <= half; ++b) {
          const auto found = cells.find({row[i] + a, column[i] + b});
          if (found == cells.end()) continue;
          const auto& [count, total] = found->second;
          const bool own = a == 0 && b == 0;
          const double k = std::exp(-std::hypot(a, b)) / norm;
          weight += k * (count - (own ? 1 : 0));
          motion += k * (total - (own ? total * (1 / count) : cv::Point2d()));
        }
      }
      const cv::Point2d mean = weight > 1e-12 ? motion * (1 / weight) : cv::Point2d();
      d2[i] = (v[i] - mean).dot(v[i] - mean);
      if (1 - std::exp(-d2[i] / 0.08) < lambdas[round]) {
        close += 1;
        sum += d2[i];
      }
    }
    const double s2 = sum / close / 2, g = close / double(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double e = std::exp(-d2[i] / (2 * s2));
      p[i] = e / (e + 2 * CV_PI * s2 * (1 - g) / (16 * g));
    }
  }
  return p;
}

TEST(Laf, FollowsTheDefinition) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Correspondences m = homographyScene({400, 0.6, 1.0, seed}).matches;
    // Distinct pixels in both images.
    std::vector<std::uint32_t> rows;
    std::map<std::pair<int, int>, int> left, right;
    for (std::uint32_t i = 0; i < m.size(); ++i) {
      if (left[{cvRound(m.left_x[i]), cvRound(m.left_y[i])}]++ == 0 &&
          right[{cvRound(m.right_x[i]), cvRound(m.right_y[i])}]++ == 0)
        rows.push_back(i);
    }
    m = m.subset(rows);
    ASSERT_GT(m.size(), 350u);
    for (const int rounds : {1, 2, 5}) {
      LafOptions options;
      options.rounds = rounds;
      options.noise_floor = 0;
      const Selection s = LafSelector(options).select(m);
      const std::vector<double> p = byDefinition(m, options.accept, rounds);
      EXPECT_EQ(s.iterations, rounds);
      EXPECT_TRUE(s.n_selected > 100 && s.n_selected < 340) << s.n_selected;
      for (std::size_t i = 0; i < m.size(); ++i) {
        ASSERT_NEAR(s.score[i], p[i], 1e-3) << i;
        if (std::abs(p[i] - options.accept) > 1e-3) {
          ASSERT_EQ(s.mask[i], p[i] > options.accept) << i;
        }
      }
    }
  }
}

TEST(Laf, FindsTheRightMatches) {
  const Scene scene = homographyScene({3000, 0.5, 1.0, 4});
  const Quality q = quality(createSelector("laf")->select(scene.matches).mask, scene.inlier);
  EXPECT_GT(q.precision, 95);
  EXPECT_GT(q.recall, 95);
}

TEST(Laf, NoiseAloneIsNoMotion) {
  // The right image is shifted along x. Along y, only noise moves the points.
  Scene scene = homographyScene({500, 1.0, 0.0, 5});
  Random random(1);
  for (std::size_t i = 0; i < scene.matches.size(); ++i) {
    scene.matches.right_x[i] = scene.matches.left_x[i] + 40;
    scene.matches.right_y[i] = scene.matches.left_y[i] + float(random.normal());
  }
  EXPECT_EQ(createSelector("laf")->select(scene.matches).n_selected, 500u);
  EXPECT_LT(createSelector("laf", {{"noise_floor", "0"}})->select(scene.matches).n_selected, 300u);
}

TEST(Laf, FarPointsDoNotChangeTheScales) {
  Scene scene = homographyScene({600, 0.6, 0.5, 6});
  const Selection expected = createSelector("laf")->select(scene.matches);
  addMatch(scene, *std::make_unique<Random>(1), {20, 30}, {9e5, -9e5}, false);
  addMatch(scene, *std::make_unique<Random>(2), {-9e5, 30}, {20, 30}, false);
  Selection s = createSelector("laf")->select(scene.matches);
  EXPECT_GE(quality(s.mask, scene.inlier).f, quality(expected.mask, scene.inlier).f - 1);
  EXPECT_EQ(s.mask[600] + s.mask[601], 0);
  // Without sizes of the images, nothing distinguishes the two points.
  scene.matches.left_size = scene.matches.right_size = {};
  EXPECT_LT(quality(createSelector("laf")->select(scene.matches).mask, scene.inlier).precision, 70);
}

TEST(Laf, ManyToOneMatchesDoNotShapeTheField) {
  // As many outliers as there are inliers end at five right points.
  Scene scene = homographyScene({600, 1.0, 0.5, 7});
  Random random(3);
  for (int i = 0; i < 1200; ++i) {
    const cv::Point2d target(100 + 150 * (i % 5), 300);
    addMatch(scene, random, uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1), target, false);
  }
  const Quality q = quality(createSelector("laf")->select(scene.matches).mask, scene.inlier);
  EXPECT_GT(q.recall, 95);
  EXPECT_GT(q.precision, 85);
}

TEST(Laf, GuidedStartsFromTheTrustedMatches) {
  // Most matches are outliers and agree with each other. Ratios tell the inliers.
  Scene scene = homographyScene({200, 1.0, 0.5, 9});
  Random random(4);
  for (int i = 0; i < 400; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1);
    addMatch(scene, random, left, {left.x / 2 + 390, 580 - left.y / 2}, false);
  }
  Correspondences& m = scene.matches;
  EXPECT_LT(quality(createSelector("laf")->select(m).mask, scene.inlier).precision, 50);
  const Quality guided =
      quality(createSelector("laf:guided", {{"guide_ratio", "0.7"}})->select(m).mask, scene.inlier);
  EXPECT_GT(guided.precision, 90);
  EXPECT_GT(guided.recall, 90);
  // Too few trusted matches are no guide.
  const OptionMap nothing = {{"guided", "true"}, {"guide_ratio", "0"}};
  EXPECT_EQ(createSelector("laf", nothing)->select(m).mask, createSelector("laf")->select(m).mask);
  m.second_distance.clear();
  const Selection s = createSelector("laf:guided")->select(m);
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_TRUE(contains(s.message, "laf with guided = true needs")) << s.message;
}

TEST(Laf, DecidesDegenerateInput) {
  const Scene scene = homographyScene({50, 1.0, 0.0, 8});
  const LafSelector laf;
  const Selection few = laf.select(scene.matches.subset({0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(few.status, Status::kTooFew);
  EXPECT_EQ(few.message, "7 matches, laf needs 8");
  EXPECT_EQ(laf.select(scene.matches.subset({0, 1, 2, 3, 4, 5, 6, 7})).status, Status::kOk);
  for (const bool left : {true, false}) {
    Correspondences m = scene.matches;
    (left ? m.left_x : m.right_x).assign(50, 310);
    (left ? m.left_y : m.right_y).assign(50, 210);
    const Selection s = laf.select(m);
    EXPECT_EQ(s.status, Status::kDegenerate);
    EXPECT_EQ(s.message, "all points of an image are equal");
    EXPECT_EQ(s.n_selected, 0u);
  }
  // Identical images, with and without a noise floor.
  Correspondences same = scene.matches;
  same.right_x = same.left_x;
  same.right_y = same.left_y;
  for (const char* floor : {"7", "0"}) {
    const Selection s = createSelector("laf", {{"noise_floor", floor}})->select(same);
    EXPECT_EQ(s.status, Status::kOk);
    EXPECT_EQ(s.n_selected, 50u) << floor;
  }
  // A line, along which all left points have the same x.
  Correspondences line = scene.matches;
  line.left_x.assign(50, 100);
  for (std::size_t i = 0; i < 50; ++i) {
    line.right_x[i] = 130;
    line.right_y[i] = line.left_y[i] + 12;
  }
  EXPECT_EQ(laf.select(line).n_selected, 50u);
  // Where every match shares its pixels, all are compared with a field without motion.
  std::vector<std::uint32_t> rows(100);
  for (std::uint32_t i = 0; i < 100; ++i) rows[i] = i % 50;
  EXPECT_EQ(laf.select(same.subset(rows)).n_selected, 100u);
}

TEST(Laf, ReportsARoundInWhichNothingAgrees) {
  // Neighbouring matches move to different corners.
  Correspondences m;
  for (int i = 0; i < 8; ++i) {
    const float x = 100.F * float(i), y = 50.F * float((i * 3) % 8);
    m.add({x, y}, {x + (i % 2 == 0 ? 400.F : -400.F), y + (i % 4 < 2 ? 400.F : -400.F)});
  }
  const Selection s = LafSelector().select(m);
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(s.n_selected, 0u);
  EXPECT_EQ(s.message, "no match agrees with the field of round 1");
  EXPECT_EQ(s.iterations, 0);
}

TEST(Laf, NamesContradictingOptions) {
  EXPECT_EQ(errorOf<std::invalid_argument>([] {
              createSelector("laf", {{"min_cells", "31"}});
            }),
            "laf: option min_cells = 31 is above max_cells = 30");
}

TEST(Laf, SelectsAsTheAuthorsCodeOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const std::map<std::string, std::pair<std::size_t, std::size_t>> golden = {{"barrsmith", {71, 71}},
                                                                             {"biscuit", {143, 143}},
                                                                             {"cubechips", {138, 137}},
                                                                             {"hartley", {123, 122}},
                                                                             {"unionhouse", {70, 65}}};
  std::size_t found = 0;
  for (const LabelledPair& pair : adelaidePairs()) {
    const auto expected = golden.find(pair.name);
    if (expected == golden.end()) continue;
    ++found;
    const std::vector<std::uint32_t> selected = selectedRows(LafSelector().select(pair.matches).mask);
    const auto correct = std::count_if(selected.begin(), selected.end(),
                                       [&](std::uint32_t i) { return pair.truth.labels[i] > 0; });
    EXPECT_EQ(selected.size(), expected->second.first) << pair.name;
    EXPECT_EQ(std::size_t(correct), expected->second.second) << pair.name;
  }
  EXPECT_EQ(found, golden.size());
}

TEST(Laf, ReachesItsMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("laf");
  EXPECT_NEAR(q.precision, 98.1, 0.2);
  EXPECT_NEAR(q.recall, 96.0, 0.2);
  EXPECT_GE(q.f, 96.8);
}

}  // namespace
}  // namespace corrsel::core
