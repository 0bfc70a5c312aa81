#include <gtest/gtest.h>

#include <numeric>

#include "corrsel/selectors/acransac.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

Selection selectWith(const Correspondences& matches, const OptionMap& options = {}) {
  AcransacSelector selector;
  selector.configure(options);
  return selector.select(matches);
}

TEST(Acransac, FindsAPlaneWithoutAThreshold) {
  for (const double noise : {0.1, 0.5, 1.0, 2.0}) {
    SceneOptions options;
    options.n = 1000;
    options.noise = noise;
    const Scene scene = homographyScene(options);
    const Selection found = selectWith(scene.matches);
    EXPECT_EQ(found.status, Status::kOk) << found.message;
    EXPECT_EQ(found.model_kind, ModelKind::kHomography);
    EXPECT_GT(found.confidence, 100);
    const Quality q = quality(found.mask, scene.inlier);
    EXPECT_GE(q.precision, 99) << noise;
    EXPECT_GE(q.recall, 95) << noise;
  }
}

TEST(Acransac, FindsTheEpipolarGeometryWithoutAThreshold) {
  for (const double noise : {0.1, 0.5, 1.0}) {
    SceneOptions options;
    options.n = 1000;
    options.noise = noise;
    const Scene scene = stereoScene(options);
    const Selection found = selectWith(scene.matches, {{"model", "fundamental"}});
    EXPECT_EQ(found.status, Status::kOk) << found.message;
    EXPECT_EQ(found.model_kind, ModelKind::kFundamental);
    const Quality q = quality(found.mask, scene.inlier);
    EXPECT_GE(q.precision, 95) << noise;
    EXPECT_GE(q.recall, 97) << noise;
  }
}

TEST(Acransac, TheThresholdFollowsTheNoise) {
  SceneOptions options;
  options.n = 1000;
  const auto selected = [&](double noise, const OptionMap& values) {
    options.noise = noise;
    const Scene scene = homographyScene(options);
    return quality(selectWith(scene.matches, values).mask, scene.inlier).recall;
  };
  // 3 px are too few for noise of 2 px; the significance asks for more.
  EXPECT_LT(selected(2, {{"min_threshold", "1"}, {"max_threshold", "3"}}), 90);
  EXPECT_GT(selected(2, {{"min_threshold", "1"}}), 97);
}

TEST(Acransac, TheMaskHoldsTheMatchesWithinTheThresholdOfTheMessage) {
  const Scene scene = homographyScene();
  const Selection found = selectWith(scene.matches, {{"min_threshold", "7"}, {"max_threshold", "7"}});
  EXPECT_TRUE(contains(found.message, "threshold 7 px")) << found.message;
  ASSERT_EQ(found.score.size(), found.mask.size());
  for (std::size_t i = 0; i < found.mask.size(); ++i)
    EXPECT_EQ(found.mask[i] != 0, found.score[i] >= -49) << i;
}

/// With a test of all samples, at most one of all runs may be accepted; the smallest confidence allows fewer.
TEST(Acransac, OutliersAreNotAccepted) {
  int accepted = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SceneOptions options;
    options.inlier_ratio = 0;
    options.seed = seed;
    for (const char* const model : {"homography", "fundamental"}) {
      const Selection found =
          selectWith(homographyScene(options).matches, {{"model", model}, {"max_iterations", "2000"}});
      accepted += found.status == Status::kOk ? 1 : 0;
      EXPECT_TRUE(found.status == Status::kUncertain || found.status == Status::kNoModel) << found.message;
    }
  }
  EXPECT_LE(accepted, 1);
}

TEST(Acransac, ReportsDegenerateInput) {
  EXPECT_EQ(selectWith({}).status, Status::kTooFew);
  EXPECT_EQ(selectWith(homographyScene().matches.subset({0, 1, 2})).status, Status::kTooFew);
  // A minimal sample is never significant.
  const Selection minimal = selectWith(homographyScene({4, 1.0, 0.0, 1}).matches);
  EXPECT_NE(minimal.status, Status::kOk);
  EXPECT_EQ(minimal.n_selected, 0u);
  Correspondences equal, line;
  for (int i = 0; i < 50; ++i) {
    const auto x = static_cast<float>(i);
    equal.add({10, 10}, {20, 20});
    line.add({x, 2 * x}, {x, 2 * x});
  }
  EXPECT_EQ(selectWith(equal).status, Status::kDegenerate);
  EXPECT_EQ(selectWith(line).status, Status::kDegenerate);
}

TEST(Acransac, SelectsAllOfIdenticalImages) {
  Random random(1);
  Correspondences m;
  for (int i = 0; i < 300; ++i) {
    const cv::Point2f p = uniformPoint(random, 640, 480);
    m.add(p, p);
  }
  const Selection found = selectWith(m);
  EXPECT_EQ(found.status, Status::kOk) << found.message;
  EXPECT_EQ(found.n_selected, m.size());
}

TEST(Acransac, ReachesItsFOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  EXPECT_NEAR(adelaideMeans("acransac:f").f, 91.6, 1.5);
}

TEST(Acransac, StopsAtTheTimeLimit) {
  SceneOptions options;
  options.n = 5000;
  options.inlier_ratio = 0.02;
  const TickingClock clock(1);
  const Selection found = selectWith(homographyScene(options).matches, {{"max_seconds", "1.5"}});
  EXPECT_EQ(found.status, Status::kTimeLimit) << found.message;
  EXPECT_TRUE(contains(found.message, "max_seconds = 1.5")) << found.message;
  EXPECT_LE(clock.looks(), 4);
}

TEST(Acransac, ReportsThatThereAreNoDistances) {
  Scene scene = homographyScene();
  scene.matches.distance.clear();
  scene.matches.second_distance.clear();
  const Selection found = selectWith(scene.matches);
  EXPECT_EQ(found.status, Status::kOk);
  EXPECT_TRUE(contains(found.message, "neither descriptor distances nor probabilities")) << found.message;
}

}  // namespace
}  // namespace corrsel::core
