#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "calibrated/verdict.h"
#include "calibrated_scene.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"

namespace corrsel::core {
namespace {

using namespace calibrated_scene;
using pose_scene::angleBetween;
using pose_scene::cameras;

constexpr double kThresholdPerNoise = 2.5;

/// The rays of a scene in both precisions.
struct SceneRays {
  RayMatches matches;
  RayColumns columns;

  explicit SceneRays(const Correspondences& pairs) {
    std::vector<std::uint8_t> exists;
    unproject(pairs, matches, exists);
    take();
  }
  explicit SceneRays(const RayMatches& rays) : matches(rays) { take(); }

 private:
  void take() {
    std::vector<std::uint32_t> rows(matches.size());
    std::iota(rows.begin(), rows.end(), 0);
    columns.take(matches, rows);
  }
};

/// What a search delivers: a pose that was fitted to the matches near a start.
Pose fitted(const RayMatches& matches, Pose pose, double threshold) {
  for (int round = 0; round < 3; ++round) {
    const cv::Matx33d essential = essentialOf(pose);
    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < matches.size(); ++i)
      if (std::abs(tangentSampson(essential, matches, i)) <= 2.5 * threshold) rows.push_back(i);
    RayMatches near;
    gatherRays(matches, rows, near);
    fitPose(near, threshold, 10, pose);
  }
  return pose;
}

/// The true pose, disturbed; with any translation where there is none.
Pose start(const Pose& truth, std::uint64_t seed) {
  Random random(seed);
  Pose pose = truth;
  if (!(cv::norm(pose.translation) > 0)) pose.translation = pose_scene::randomDirection(random);
  cv::Vec<double, 5> step;
  for (int k = 0; k < 5; ++k) step[k] = random.uniform(-1e-3, 1e-3);
  return moved(pose, step);
}

Verdict decide(const SceneRays& rays, const Pose* pose, double threshold) {
  MotionVerdict verdict;
  return verdict.decide({rays.matches, rays.columns, nullptr, pose, threshold, 1});
}

Verdict decide(const Scene& scene, double threshold, std::uint64_t seed) {
  const SceneRays rays(scene.matches);
  const Pose pose = fitted(rays.matches, start(scene.truth, seed), threshold);
  return decide(rays, &pose, threshold);
}

/// Angle of the rotation between two rotations, rad.
double rotationBetween(const cv::Matx33d& a, const cv::Matx33d& b) {
  return 2 * std::asin(std::min(1.0, cv::norm(a - b) / std::sqrt(8)));
}

double poseError(const Pose& pose, const Pose& truth) {
  return std::max(rotationBetween(pose.rotation, truth.rotation),
                  angleBetween(pose.translation, truth.translation));
}

/// Calls test(scene, verdict) for all cameras, shares of inliers, noises and some seeds.
template <typename Test>
void forScenes(Scenario scenario, double baseline, const Test& test) {
  std::uint64_t seed = 0;
  for (const Camera& camera : cameras()) {
    for (const double share : {0.3, 0.6, 0.9}) {
      for (const double noise : {0.5, 2.0}) {
        SceneOptions options;
        options.scenario = scenario;
        options.camera = camera;
        options.right_share = share;
        options.noise = noise;
        options.baseline = baseline;
        const Scene scene = generate(options, ++seed);
        SCOPED_TRACE(toString(camera.model) + ", share " + std::to_string(share) + ", noise " +
                     std::to_string(noise));
        test(scene, decide(scene, kThresholdPerNoise * noise, seed));
      }
    }
  }
}

TEST(MotionVerdict, AtRest) {
  forScenes(Scenario::kRest, 0, [](const Scene&, const Verdict& verdict) {
    EXPECT_EQ(verdict.motion, Motion::kRest);
    EXPECT_EQ(verdict.rotation, cv::Matx33d::eye());
    EXPECT_LT(verdict.parallax, 5);
  });
}

// The pose aligns the few large errors with its epipolar lines, and the many small ones agree with any pose.
TEST(MotionVerdict, NoiseWithHeavyTailsAtRest) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SceneOptions options;
    options.scenario = Scenario::kRest;
    options.size = 1000;
    options.right_share = 0.9;
    options.noise = 0.05;
    Scene scene = generate(options, seed);
    Random random(seed);
    for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
      if (!scene.inlier[i] || random.index(20) != 0) continue;
      const double angle = random.uniform(0, 2 * CV_PI);
      const double distance = random.uniform(0.5, 4);
      scene.matches.right_x[i] += static_cast<float>(distance * std::cos(angle));
      scene.matches.right_y[i] += static_cast<float>(distance * std::sin(angle));
    }
    EXPECT_EQ(decide(scene, 1, seed).motion, Motion::kRest) << seed;
  }
}

TEST(MotionVerdict, Rotation) {
  for (const Scenario scenario : {Scenario::kRotation, Scenario::kPlane}) {
    forScenes(scenario, 0, [](const Scene& scene, const Verdict& verdict) {
      EXPECT_EQ(verdict.motion, Motion::kRotation);
      EXPECT_LT(rotationBetween(verdict.rotation, scene.truth.rotation), 4e-3);
      EXPECT_FALSE(verdict.second);
    });
  }
}

TEST(MotionVerdict, General) {
  for (const double baseline : {0.05, 0.3}) {
    forScenes(Scenario::kGeneral, baseline, [&](const Scene& scene, const Verdict& verdict) {
      EXPECT_EQ(verdict.motion, Motion::kGeneral);
      EXPECT_LT(poseError(verdict.pose, scene.truth), 0.02 / baseline);
      EXPECT_GT(verdict.parallax, 5);
    });
  }
}

TEST(MotionVerdict, Forward) {
  forScenes(Scenario::kForward, 0.2, [](const Scene& scene, const Verdict& verdict) {
    EXPECT_EQ(verdict.motion, Motion::kGeneral);
    EXPECT_LT(poseError(verdict.pose, scene.truth), 0.1);
  });
}

TEST(MotionVerdict, PlaneHasTwoPoses) {
  int second = 0;
  for (const double baseline : {0.2, 0.5}) {
    forScenes(Scenario::kPlane, baseline, [&](const Scene& scene, const Verdict& verdict) {
      EXPECT_EQ(verdict.motion, Motion::kPlanar);
      double error = poseError(verdict.pose, scene.truth);
      if (verdict.second) error = std::min(error, poseError(*verdict.second, scene.truth));
      EXPECT_LT(error, 0.1);
      second += verdict.second ? 1 : 0;
    });
  }
  EXPECT_GT(second, 4);
}

/// Exact rays of a plane: whichever of its two poses is given, both are found.
TEST(MotionVerdict, PosesOfTheExamplePlane) {
  const cv::Matx33d other_rotation(0.987135618114, -0.159706797978, -0.007550505285, 0.159067836856,
                                   0.985762569600, -0.054493849693, 0.016146043735, 0.052591777457,
                                   0.998485558341);
  const cv::Vec3d normal(0.05, -0.1, 0.2), other_normal(-0.883176932060, -0.322275605223, 0.340788704264);
  const Pose truth = pose_scene::examplePose();
  Pose other;
  other.rotation = other_rotation;
  other.translation = cv::normalize(cv::Vec3d(-0.040026822324, 0.110553982759, -0.196661308830));
  RayMatches matches;
  Random random(1);
  while (matches.size() < 100) {
    const cv::Point2d left = uniformPixel({640, 480}, random);
    Ray ray;
    cv::Point2d right;
    ASSERT_TRUE(unproject(pose_scene::exampleCamera(), left, ray));
    const double inverse_depth = normal.dot(ray.direction);
    // Under both poses, the points are in front of both cameras.
    if (!(inverse_depth > 0.02) || !(other_normal.dot(ray.direction) > 0.02)) continue;
    const cv::Vec3d point = truth.rotation * (ray.direction * (1 / inverse_depth)) + truth.translation;
    if (project(pose_scene::exampleCamera(), point, right))
      pose_scene::append(pose_scene::exampleCamera(), left, right, matches);
  }
  const SceneRays rays(matches);
  for (const Pose& given : {truth, other}) {
    const Verdict verdict = decide(rays, &given, 1);
    ASSERT_EQ(verdict.motion, Motion::kPlanar);
    ASSERT_TRUE(verdict.second);
    for (const Pose& expected : {truth, other})
      EXPECT_LT(std::min(poseError(verdict.pose, expected), poseError(*verdict.second, expected)), 1e-5);
  }
}

/// The threshold of a user who does not know the noise.
TEST(MotionVerdict, ThresholdBelowTheNoise) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SceneOptions options;
    options.noise = 2;
    options.right_share = 0.8;
    options.size = 1000;
    options.scenario = Scenario::kRotation;
    EXPECT_EQ(decide(generate(options, seed), 1, seed).motion, Motion::kRotation) << seed;
    options.scenario = Scenario::kRest;
    EXPECT_EQ(decide(generate(options, seed), 1, seed).motion, Motion::kRest) << seed;
    options.scenario = Scenario::kPlane;
    EXPECT_EQ(decide(generate(options, seed), 1, seed).motion, Motion::kPlanar) << seed;
    options.scenario = Scenario::kGeneral;
    EXPECT_EQ(decide(generate(options, seed), 1, seed).motion, Motion::kGeneral) << seed;
  }
}

TEST(MotionVerdict, RotationWithoutPose) {
  SceneOptions options;
  options.scenario = Scenario::kRotation;
  options.right_share = 0.2;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = generate(options, seed);
    const Verdict verdict = decide(SceneRays(scene.matches), nullptr, 2);
    EXPECT_EQ(verdict.motion, Motion::kRotation) << seed;
    EXPECT_LT(rotationBetween(verdict.rotation, scene.truth.rotation), 2e-3) << seed;
  }
}

TEST(MotionVerdict, OutliersShowNothing) {
  SceneOptions options;
  options.right_share = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = generate(options, seed);
    const SceneRays rays(scene.matches);
    const Pose pose = fitted(rays.matches, start(scene.truth, seed), 1);
    EXPECT_EQ(decide(rays, &pose, 1).motion, Motion::kNone) << seed;
  }
}

TEST(MotionVerdict, TooFewMatches) {
  SceneOptions options;
  options.right_share = 1;
  for (const std::size_t size : {0, 1, 4, 7}) {
    options.size = size;
    const Scene scene = generate(options, size);
    EXPECT_EQ(decide(SceneRays(scene.matches), &scene.truth, 1).motion, Motion::kNone) << size;
  }
}

TEST(MotionVerdict, OnePlaceShowsNothing) {
  Correspondences pairs;
  pairs.left_camera = pairs.right_camera = pose_scene::pinhole();
  for (int i = 0; i < 50; ++i) pairs.add({500, 400}, {510, 390});
  const Pose pose = pose_scene::examplePose();
  EXPECT_EQ(decide(SceneRays(pairs), &pose, 1).motion, Motion::kNone);
  EXPECT_EQ(decide(SceneRays(pairs), nullptr, 1).motion, Motion::kNone);
}

}  // namespace
}  // namespace corrsel::core
