#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "calibrated/pose_refinement.h"
#include "calibrated_scene.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"

namespace corrsel::core {
namespace {

using namespace calibrated_scene;
using pose_scene::angleBetween;

constexpr double kThreshold = 2.5;

/// The rays of a scene in both precisions, and a refinement.
struct Fixture {
  RayMatches rays;
  RayColumns columns;
  PoseRefinement refinement;

  explicit Fixture(const Correspondences& pairs) {
    std::vector<std::uint8_t> exists;
    unproject(pairs, rays, exists);
    std::vector<std::uint32_t> rows(rays.size());
    std::iota(rows.begin(), rows.end(), 0U);
    columns.take(rays, rows);
  }

  bool refine(Pose& pose, bool robust = true, const std::vector<std::uint8_t>* candidates = nullptr) {
    return refinement.refine(rays, columns, kThreshold, robust, candidates, PoseFreedom::all(), pose);
  }
};

Pose disturbed(const Pose& pose) { return moved(pose, {2e-3, -2e-3, 2e-3, 0.03, -0.03}); }

double errorOf(const Pose& pose, const Pose& truth) {
  return cv::norm(pose.rotation - truth.rotation) + angleBetween(pose.translation, truth.translation);
}

Scene sceneOf(const Camera& camera, std::uint64_t seed) {
  SceneOptions options;
  options.camera = camera;
  return generate(options, seed);
}

TEST(PoseRefinement, ComesNearerToTheTruth) {
  for (const Camera& camera : pose_scene::cameras()) {
    double before = 0, after = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Scene scene = sceneOf(camera, seed);
      Fixture fixture(scene.matches);
      Pose pose = disturbed(scene.truth);
      before += errorOf(pose, scene.truth);
      ASSERT_TRUE(fixture.refine(pose));
      after += errorOf(pose, scene.truth);
    }
    EXPECT_LT(after, 0.4 * before) << toString(camera.model);
  }
}

TEST(PoseRefinement, DescribesTheMatchesUnderTheLastPose) {
  const Scene scene = sceneOf(pose_scene::fisheye(), 7);
  Fixture fixture(scene.matches);
  Pose pose = disturbed(scene.truth);
  ASSERT_TRUE(fixture.refine(pose));
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < fixture.rays.size(); ++i) {
    const double r = tangentSampson(essentialOf(pose), fixture.rays, i);
    EXPECT_NEAR(fixture.refinement.errors()[i], r * r, 1e-9 * (1 + r * r));
    if (std::abs(r) <= kThreshold && isInFront(pose, fixture.rays, i, kThreshold)) expected.push_back(i);
  }
  EXPECT_EQ(fixture.refinement.agreeing(), expected);
  EXPECT_GT(expected.size(), 140U);
  EXPECT_GE(fixture.refinement.fitted().size(), 140U);
}

TEST(PoseRefinement, LeavesAgreementsByChanceOut) {
  SceneOptions options;
  options.right_share = 0.3;
  options.size = 800;
  const Scene scene = generate(options, 8);
  Fixture fixture(scene.matches);
  Pose pose = scene.truth, robust = scene.truth;
  ASSERT_TRUE(fixture.refine(pose, false));
  const std::size_t all = fixture.refinement.fitted().size();
  ASSERT_TRUE(fixture.refine(robust, true));
  EXPECT_GT(fixture.refinement.chance().share(), 0);
  EXPECT_LT(fixture.refinement.fitted().size(), all);
  // Nothing of one call is left in the next one.
  ASSERT_TRUE(fixture.refine(pose, false));
  EXPECT_EQ(fixture.refinement.chance().share(), 0);
  EXPECT_EQ(fixture.refinement.chance().expectedAmongCounting(), 0);
}

TEST(PoseRefinement, TakesCandidatesOnly) {
  const Scene scene = sceneOf(pose_scene::pinhole(), 9);
  Fixture fixture(scene.matches);
  std::vector<std::uint8_t> candidates = scene.inlier;
  Pose pose = disturbed(scene.truth);
  ASSERT_TRUE(fixture.refine(pose, true, &candidates));
  for (const std::uint32_t i : fixture.refinement.agreeing()) EXPECT_NE(scene.inlier[i], 0) << i;
  EXPECT_LE(fixture.refinement.fitted().size(), 150U);
  EXPECT_LT(errorOf(pose, scene.truth), 0.05);
}

TEST(PoseRefinement, FailsWhereTheCandidatesDoNotDetermineThePose) {
  const Scene scene = sceneOf(pose_scene::pinhole(), 10);
  Fixture fixture(scene.matches);
  const Pose start = disturbed(scene.truth);
  std::vector<std::uint8_t> few(scene.inlier.size(), 0);
  for (std::size_t i = 0, n = 0; i < few.size() && n < 5; ++i) n += few[i] = scene.inlier[i];
  Pose pose = start;
  EXPECT_FALSE(fixture.refine(pose, true, &few));
  EXPECT_EQ(pose.rotation, start.rotation);
  EXPECT_EQ(pose.translation, start.translation);

  // The same match, many times: the normal equations are singular.
  Fixture one(scene.matches.subset(std::vector<std::uint32_t>(50, selectedRows(scene.inlier)[0])));
  pose = scene.truth;
  EXPECT_FALSE(one.refine(pose));
  EXPECT_EQ(pose.rotation, scene.truth.rotation);
}

}  // namespace
}  // namespace corrsel::core
