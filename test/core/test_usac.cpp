#include <gtest/gtest.h>

#include "corrsel/selectors/usac.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

UsacOptions homography(double threshold) {
  UsacOptions options;
  options.threshold = threshold;
  return options;
}

Scene withoutDistances(Scene scene) {
  scene.matches.distance.clear();
  scene.matches.second_distance.clear();
  return scene;
}

TEST(Usac, FindsModelsAmongFewInliers) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene plane = withoutDistances(homographyScene({1000, 0.08, 0.5, seed}));
    const Selection s = UsacSelector(homography(3)).select(plane.matches);
    EXPECT_EQ(s.status, Status::kOk);
    const Quality q = quality(s.mask, plane.inlier);
    EXPECT_GT(q.recall, 95);
    EXPECT_GT(q.precision, 95);
  }
  UsacOptions options;
  options.model = ModelKind::kFundamental;
  const Scene space = withoutDistances(stereoScene({800, 0.35, 0.3, 3}));
  const Quality q = quality(UsacSelector(options).select(space.matches).mask, space.inlier);
  EXPECT_GT(q.recall, 95);
  EXPECT_GT(q.precision, 90);
}

/// The best descriptor ratios may all lie in one corner, where many a wrong homography fits within the
/// threshold (VGG, trees 1-2): PROSAC must not stop by them alone.
TEST(Usac, BestMatchesInOneCornerDoNotEndTheSearch) {
  double sum = 0;
  for (int seed = 0; seed < 10; ++seed) {
    Scene scene = homographyScene({3000, 0.4, 2.0, static_cast<std::uint64_t>(seed + 1)});
    Correspondences& m = scene.matches;
    for (std::size_t i = 0; i < m.size(); ++i) {
      const bool corner = m.left_x[i] > 700 && m.left_y[i] > 450;
      if (scene.inlier[i] && corner) m.distance[i] *= 0.3F;
    }
    UsacOptions options = homography(10);
    options.seed = seed;
    const Quality q = quality(UsacSelector(options).select(m).mask, scene.inlier);
    EXPECT_GT(q.recall, 60) << seed;
    sum += q.recall;
  }
  EXPECT_GT(sum / 10, 94);
}

TEST(Usac, ThresholdZeroStandsForThePapersValues) {
  const Scene plane = homographyScene({300, 0.6, 2.0, 1}), space = stereoScene({300, 0.6, 1.0, 1});
  EXPECT_EQ(UsacSelector().select(plane.matches).mask,
            UsacSelector(homography(10)).select(plane.matches).mask);
  const auto f = [&space](const char* threshold) {
    return createSelector("usac:f", {{"threshold", threshold}})->select(space.matches).mask;
  };
  EXPECT_EQ(f("0"), f("1.5"));
  EXPECT_NE(f("0"), f("10"));
}

TEST(Usac, MaskIsSymmetricTransferWithinTheThreshold) {
  const Scene scene = homographyScene({500, 0.5, 1.5, 2});
  const Selection s = UsacSelector(homography(3)).select(scene.matches);
  const cv::Matx33d inverse = s.model.inv();
  for (std::size_t i = 0; i < 500; ++i) {
    const Correspondences& m = scene.matches;
    const cv::Point2d there =
        projected(s.model, m.left_x[i], m.left_y[i]) - cv::Point2d(m.right_x[i], m.right_y[i]);
    const cv::Point2d back =
        projected(inverse, m.right_x[i], m.right_y[i]) - cv::Point2d(m.left_x[i], m.left_y[i]);
    const double error = there.dot(there) + back.dot(back);
    if (std::abs(error - 9) > 1e-6) {
      EXPECT_EQ(s.mask[i], error <= 9 ? 1 : 0) << error;
    }
  }
}

TEST(Usac, ProsacNeedsFewerHypothesesAndSaysWhenItCannot) {
  const Scene scene = homographyScene({2000, 0.2, 0.5, 2});  // ratios tell right from wrong here
  const Selection sorted = UsacSelector(homography(3)).select(scene.matches);
  EXPECT_EQ(sorted.message, "");
  EXPECT_GT(quality(sorted.mask, scene.inlier).recall, 99);
  const Scene blind = withoutDistances(scene);
  const Selection uniform = UsacSelector(homography(3)).select(blind.matches);
  EXPECT_EQ(uniform.message,
            "the matches have no descriptor distances, so samples are drawn uniformly "
            "instead of by PROSAC");
  EXPECT_GT(quality(uniform.mask, scene.inlier).recall, 99);
  EXPECT_LT(10 * sorted.iterations, uniform.iterations);
  // The wrong way round must only cost time.
  Scene misled = scene;
  std::swap(misled.matches.distance, misled.matches.second_distance);
  EXPECT_GT(quality(UsacSelector(homography(3)).select(misled.matches).mask, scene.inlier).recall, 99);
}

TEST(Usac, EveryPartCanBeTakenOut) {
  const Scene plane = homographyScene({800, 0.3, 0.5, 4}), space = stereoScene({800, 0.5, 0.3, 4});
  for (const OptionMap& options : {OptionMap{{"sprt", "false"}},
                                   {{"local_optimization", "false"}},
                                   {{"degensac", "false"}},
                                   {{"sampler", "uniform"}},
                                   {{"score", "inlier_count"}},
                                   {{"refine", "false"}},
                                   {{"error", "transfer"}}}) {
    SCOPED_TRACE(options.begin()->first);
    EXPECT_GT(quality(createSelector("usac:h", options)->select(plane.matches).mask, plane.inlier).f, 98);
    EXPECT_GT(quality(createSelector("usac:f", options)->select(space.matches).mask, space.inlier).f, 95);
  }
}

TEST(Usac, SprtSavesTimeAndLosesNothing) {
  int with = 0, without = 0;
  for (int seed = 0; seed < 20; ++seed) {
    const Scene scene = withoutDistances(homographyScene({1000, 0.1, 1.0, std::uint64_t(seed) + 1}));
    OptionMap options = {{"threshold", "3"}, {"seed", std::to_string(seed)}, {"error", "transfer"}};
    with += quality(createSelector("usac:h", options)->select(scene.matches).mask, scene.inlier).recall > 90;
    options["sprt"] = "false";
    without +=
        quality(createSelector("usac:h", options)->select(scene.matches).mask, scene.inlier).recall > 90;
  }
  EXPECT_GE(with, without - 1);
  EXPECT_GE(with, 19);
}

TEST(Usac, EndsInTimeWhereHardlyAnySampleIsValid) {
  // All but three matches stand on a line: nearly every sample is refused.
  Correspondences m;
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const float t = float(random.uniform(0, 500));
    m.add({t, t}, {2 * t, 3 * t});
  }
  for (int i = 0; i < 3; ++i) m.add({float(random.uniform(0, 500)), 0}, {0, float(random.uniform(0, 500))});
  const Selection s = UsacSelector().select(m);
  EXPECT_LT(s.seconds, 60);
  EXPECT_EQ(s.mask.size(), 3003u);
}

TEST(Usac, PointsClosestTogetherAreAllWithinTheThreshold) {
  // A threshold of 10 px is 1e21 of these units: its square is no float.
  Correspondences m = homographyScene({100, 0.5, 0.5, 1}).matches;
  for (auto* column : {&m.left_x, &m.left_y, &m.right_x, &m.right_y}) {
    for (float& value : *column) value *= 1e-22f;
  }
  for (const char* spec : {"usac:h", "usac:f", "ransac:h"}) {
    const Selection s = createSelector(spec)->select(m);
    EXPECT_TRUE(s.status == Status::kDegenerate || s.n_selected == 100) << spec << ": " << s.message;
    EXPECT_EQ(s.mask.size(), 100u);
  }
}

TEST(Usac, TinyThresholdsKeepExactMatches) {
  Correspondences m = homographyScene({100, 1.0, 0.0, 1}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  const Selection s = createSelector("usac:h", {{"threshold", "1e-30"}})->select(m);
  EXPECT_EQ(s.mask.size(), 100u);
  EXPECT_NE(s.status, Status::kFailed);
}

TEST(Usac, ReachesItsMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("usac:f");
  EXPECT_GE(q.precision, 96);
  EXPECT_GE(q.f, 85);
}

}  // namespace
}  // namespace corrsel::core
