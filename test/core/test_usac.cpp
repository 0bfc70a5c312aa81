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

TEST(Usac, ThresholdZeroStandsForTheValuesOfTheErrors) {
  const Scene plane = homographyScene({300, 0.6, 2.0, 1}), space = stereoScene({300, 0.6, 1.0, 1});
  const auto h = [&plane](const char* error, const char* threshold) {
    return createSelector("usac:h", {{"error", error}, {"threshold", threshold}})->select(plane.matches).mask;
  };
  EXPECT_EQ(UsacSelector().select(plane.matches).mask, h("smaller_transfer", "5"));
  EXPECT_NE(UsacSelector().select(plane.matches).mask, h("smaller_transfer", "2"));
  for (const char* error : {"symmetric_transfer", "transfer"}) {
    EXPECT_EQ(h(error, "0"), h(error, "10"));
    EXPECT_NE(h(error, "0"), h(error, "2"));
  }
  const auto f = [&space](const char* threshold) {
    return createSelector("usac:f", {{"threshold", threshold}})->select(space.matches).mask;
  };
  EXPECT_EQ(f("0"), f("1.5"));
  EXPECT_NE(f("0"), f("10"));
}

TEST(Usac, MaskIsTheErrorWithinTheThreshold) {
  const Scene scene = homographyScene({500, 0.5, 1.5, 2});
  for (const bool smaller : {true, false}) {
    UsacOptions options = homography(3);
    options.error = smaller ? UsacOptions::Error::kSmallerTransfer : UsacOptions::Error::kSymmetricTransfer;
    const Selection s = UsacSelector(options).select(scene.matches);
    const cv::Matx33d inverse = s.model.inv();
    int differ = 0;
    for (std::size_t i = 0; i < 500; ++i) {
      const Correspondences& m = scene.matches;
      const cv::Point2d there =
          projected(s.model, m.left_x[i], m.left_y[i]) - cv::Point2d(m.right_x[i], m.right_y[i]);
      const cv::Point2d back =
          projected(inverse, m.right_x[i], m.right_y[i]) - cv::Point2d(m.left_x[i], m.left_y[i]);
      const double sum = there.dot(there) + back.dot(back),
                   least = std::min(there.dot(there), back.dot(back));
      const double error = smaller ? least : sum;
      differ += (least <= 9) != (sum <= 9);
      if (std::abs(error - 9) > 1e-6) {
        EXPECT_EQ(s.mask[i], error <= 9 ? 1 : 0) << error;
      }
    }
    EXPECT_GT(differ, 10);
  }
}

/// The right image shows the plane four times as large, so that the noise of the left points is four times as
/// large there.
TEST(Usac, ZoomCostsNoRecall) {
  Random random(5);
  Correspondences m;
  for (int i = 0; i < 600; ++i) {
    const cv::Point2d left = uniformPoint(random, 200, 150), noisy = left + 1.5 * normalPoint(random);
    const cv::Point2d right = i < 300 ? 4 * left : uniformPoint(random, 800, 600);
    m.add(cv::Point2f(noisy), cv::Point2f(right));
  }
  std::vector<std::uint8_t> inlier(600, 0);
  std::fill(inlier.begin(), inlier.begin() + 300, std::uint8_t{1});
  EXPECT_GT(quality(UsacSelector().select(m).mask, inlier).recall, 98);
  EXPECT_LT(quality(createSelector("usac:paper")->select(m).mask, inlier).recall, 90);
}

/// Inliers are rare, but less so among the best.
TEST(Usac, ShortPrefixesFindRareInliers) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Scene scene = homographyScene({3000, 0.015, 0.5, seed});
    Random random(seed);
    for (std::size_t i = 0; i < scene.matches.size(); ++i) {
      scene.matches.second_distance[i] = 100;
      scene.matches.distance[i] =
          static_cast<float>(random.uniform(scene.inlier[i] ? 30 : 50, scene.inlier[i] ? 90 : 100));
    }
    const Selection s = UsacSelector(homography(3)).select(scene.matches);
    EXPECT_LE(s.iterations, 60000);
    found += quality(s.mask, scene.inlier).recall > 90 ? 1 : 0;
  }
  EXPECT_GE(found, 9);
}

/// With few matches, all models that chance does not explain have soon been drawn.
TEST(Usac, StopsWhereNothingSignificantIsLeftToFind) {
  const Correspondences small = homographyScene({40, 0.0, 0.5, 1}).matches;
  const Selection s = UsacSelector(homography(3)).select(small);
  EXPECT_LT(s.iterations, 40000);
  EXPECT_GT(s.iterations, 1000);
  // Confidence 1 never stops early.
  UsacOptions all = homography(3);
  all.confidence = 1;
  EXPECT_EQ(UsacSelector(all).select(small).iterations, 60000);
  // A third of so few matches is found before.
  const Scene right = withoutDistances(homographyScene({60, 0.35, 0.5, 1}));
  EXPECT_GT(quality(UsacSelector(homography(3)).select(right.matches).mask, right.inlier).recall, 95);
}

/// Where nothing is to be found, the number of hypotheses bounds the time, to 0.1 s at most.
TEST(Usac, HopelessSearchesEndSoon) {
  const Correspondences ordered = homographyScene({1000, 0.0, 0.5, 1}).matches;
  const Correspondences blind = withoutDistances(homographyScene({1000, 0.0, 0.5, 1})).matches;
  for (const Correspondences& matches : {ordered, blind}) {
    EXPECT_EQ(createSelector("usac:h")->select(matches).iterations, 60000);
    EXPECT_EQ(createSelector("acransac:h")->select(matches).iterations, 60000);
    EXPECT_EQ(createSelector("usac:f")->select(matches).iterations, 40000);
    EXPECT_EQ(createSelector("acransac:f")->select(matches).iterations, 40000);
  }
}

/// Samples with an outlier or two lead to the model long before a sample without one is drawn: at 20 % of
/// inliers, one in 80000.
TEST(Usac, InnerSamplesFindModelsAmongFewInliers) {
  int fundamental = 0, plane = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene space = withoutDistances(stereoScene({500, 0.2, 0.6, seed}));
    const Scene flat = withoutDistances(homographyScene({2000, 0.05, 0.5, seed}));
    fundamental += quality(createSelector("usac:f")->select(space.matches).mask, space.inlier).recall > 75;
    plane += quality(createSelector("usac:h")->select(flat.matches).mask, flat.inlier).recall > 90;
  }
  EXPECT_GE(fundamental, 9);
  EXPECT_GE(plane, 9);
}

/// The SPRT must not reject fundamental matrices that the search can find. Designed for 15 % of inliers, it
/// loses more than half of these.
TEST(Usac, FindsEpipolarGeometryAmongFewInliers) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = stereoScene({600, 0.08, 0.6, seed});
    const Selection s = createSelector("usac:f")->select(scene.matches);
    found += quality(s.mask, scene.inlier).recall > 75 ? 1 : 0;
  }
  EXPECT_GE(found, 9);
}

TEST(Usac, ProsacNeedsFewerHypothesesAndSaysWhenItCannot) {
  const Scene scene = homographyScene({2000, 0.2, 0.5, 2});  // ratios tell right from wrong here
  const Selection sorted = UsacSelector(homography(3)).select(scene.matches);
  EXPECT_EQ(sorted.message, "");
  EXPECT_GT(quality(sorted.mask, scene.inlier).recall, 99);
  const Scene blind = withoutDistances(scene);
  const Selection uniform = UsacSelector(homography(3)).select(blind.matches);
  EXPECT_EQ(uniform.message,
            "the matches have neither descriptor distances nor probabilities, so samples are drawn uniformly "
            "instead of by PROSAC");
  EXPECT_GT(quality(uniform.mask, scene.inlier).recall, 99);
  EXPECT_LT(10 * sorted.iterations, uniform.iterations);
  // The probabilities of a matcher order the samples as well as distances do.
  Scene learned = blind;
  for (std::size_t i = 0; i < scene.matches.size(); ++i) {
    learned.matches.probability.push_back(1 - scene.matches.distance[i] / scene.matches.second_distance[i]);
  }
  const Selection guided = UsacSelector(homography(3)).select(learned.matches);
  EXPECT_EQ(guided.message, "");
  EXPECT_LT(10 * guided.iterations, uniform.iterations);
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
  for (int i = 0; i < 3; ++i) {
    const float y = float(random.uniform(0, 500)), x = float(random.uniform(0, 500));
    m.add({x, 0}, {0, y});
  }
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
