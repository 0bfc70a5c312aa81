#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "corrsel/datasets/calibrated_scene.h"
#include "corrsel/evaluation/pose.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr SceneMotion kMotions[] = {SceneMotion::kRest, SceneMotion::kRotation, SceneMotion::kGeneral,
                                    SceneMotion::kForward, SceneMotion::kPlane};

std::vector<Camera> cameras() { return {scenePinhole(), sceneRational(), sceneFisheye(), scenePanorama()}; }

CalibratedSceneSpec specOf(const Camera& camera, SceneMotion motion) {
  CalibratedSceneSpec spec;
  spec.left_camera = spec.right_camera = camera;
  spec.motion = motion;
  spec.n = 300;
  return spec;
}

/// The rays of a match.
std::pair<cv::Vec3d, cv::Vec3d> raysOf(const CalibratedScene& scene, std::size_t i) {
  const Correspondences& m = scene.matches;
  Ray left, right;
  EXPECT_TRUE(unproject(*m.left_camera, {m.left_x[i], m.left_y[i]}, left));
  EXPECT_TRUE(unproject(*m.right_camera, {m.right_x[i], m.right_y[i]}, right));
  return {left.direction, right.direction};
}

/// The point of a right match without noise, in the frame of the left camera: where both rays are nearest.
cv::Vec3d pointOf(const CalibratedScene& scene, std::size_t i) {
  const auto [left, right] = raysOf(scene, i);
  const cv::Vec3d a = scene.pose.rotation * left, &b = right, &t = scene.pose.translation;
  const double c = a.dot(b);
  return left * ((c * b.dot(t) - a.dot(t)) / (1 - c * c));
}

TEST(CalibratedScene, MatchesLieInTheImagesAndHaveCameras) {
  for (const Camera& camera : cameras()) {
    EXPECT_NO_THROW(camera.check());
    for (const SceneMotion motion : kMotions) {
      const CalibratedScene scene = makeCalibratedScene(specOf(camera, motion));
      const Correspondences& m = scene.matches;
      EXPECT_EQ(m.inconsistency(), "");
      ASSERT_EQ(m.size(), 300u);
      EXPECT_EQ(std::count(scene.inlier.begin(), scene.inlier.end(), 1), 210);
      EXPECT_EQ(m.left_camera, camera);
      EXPECT_EQ(m.right_size, camera.size);
      for (std::size_t i = 0; i < m.size(); ++i) {
        for (const float x : {m.left_x[i], m.right_x[i]}) EXPECT_TRUE(x >= 0 && x <= camera.size.width - 1);
        for (const float y : {m.left_y[i], m.right_y[i]}) EXPECT_TRUE(y >= 0 && y <= camera.size.height - 1);
      }
      EXPECT_NO_THROW(scene.pose.check());
    }
  }
}

TEST(CalibratedScene, MotionsAreWhatTheyAreCalled) {
  for (const SceneMotion motion : kMotions) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      CalibratedSceneSpec spec = specOf(scenePinhole(), motion);
      spec.n = 1;
      spec.baseline = 0.25;
      spec.seed = seed;
      const CalibratedScene scene = makeCalibratedScene(spec);
      const cv::Vec3d& t = scene.pose.translation;
      const double angle = poseErrors(cv::Matx33d::eye(), {}, scene.pose).rotation;
      const bool moved = motion != SceneMotion::kRest && motion != SceneMotion::kRotation;
      EXPECT_NEAR(cv::norm(t), moved ? 2 : 0, 1e-12);
      EXPECT_TRUE(motion == SceneMotion::kRest ? angle == 0 : angle > 2 && angle < 15) << angle;
      if (motion == SceneMotion::kForward) {
        const cv::Vec3d centre = -(scene.pose.rotation.t() * t);  // of the right camera
        EXPECT_NEAR(cv::norm(centre - cv::Vec3d(0, 0, 2)), 0, 1e-12);
      }
      const Motion expected = motion == SceneMotion::kRest       ? Motion::kRest
                              : motion == SceneMotion::kRotation ? Motion::kRotation
                              : motion == SceneMotion::kPlane    ? Motion::kPlanar
                                                                 : Motion::kGeneral;
      EXPECT_EQ(scene.motion, expected);
    }
  }
}

TEST(CalibratedScene, RightMatchesWithoutNoiseArePointsOfTheScene) {
  for (const Camera& camera : cameras()) {
    CalibratedSceneSpec spec = specOf(camera, SceneMotion::kGeneral);
    spec.noise = 0;
    const CalibratedScene space = makeCalibratedScene(spec);
    double least = 100, largest = 0;
    for (std::size_t i = 0; i < space.inlier.size(); ++i) {
      if (space.inlier[i] == 0) continue;
      // Rays that are nearly parallel to the baseline do not tell the distance.
      const auto [left, right] = raysOf(space, i);
      if (cv::norm((space.pose.rotation * left).cross(right)) < 0.02) continue;
      const double distance = cv::norm(pointOf(space, i));
      least = std::min(least, distance);
      largest = std::max(largest, distance);
    }
    EXPECT_TRUE(least > 3.95 && least < 4.6) << least;
    EXPECT_TRUE(largest < 12.1 && largest > 11.2) << largest;
    spec.motion = SceneMotion::kPlane;
    const CalibratedScene plane = makeCalibratedScene(spec);
    cv::Mat points(0, 3, CV_64F);
    for (std::size_t i = 0; i < plane.inlier.size(); ++i) {
      if (plane.inlier[i] == 0) continue;
      const auto [left, right] = raysOf(plane, i);
      if (cv::norm((plane.pose.rotation * left).cross(right)) < 0.05) continue;
      points.push_back(cv::Mat(pointOf(plane, i)).t());
    }
    ASSERT_GT(points.rows, 50);
    cv::Mat normal;
    cv::solve(points, cv::Mat(points.rows, 1, CV_64F, cv::Scalar(8)), normal, cv::DECOMP_SVD);
    EXPECT_LT(cv::norm(points * normal - 8, cv::NORM_INF), 0.05);
    EXPECT_NEAR(normal.at<double>(2), 1, 0.01);
  }
}

TEST(CalibratedScene, NoiseIsInBothImages) {
  CalibratedSceneSpec spec = specOf(sceneFisheye(), SceneMotion::kRest);
  spec.n = 4000;
  spec.inlier_ratio = 1;
  spec.noise = 2;
  const Correspondences m = makeCalibratedScene(spec).matches;
  double sum = 0;
  for (std::size_t i = 0; i < m.size(); ++i) sum += std::pow(m.left_x[i] - m.right_x[i], 2);
  EXPECT_NEAR(sum / 4000, 2 * 4, 0.6);  // three standard deviations
}

TEST(CalibratedScene, DependsOnTheSeedAlone) {
  CalibratedSceneSpec spec = specOf(scenePanorama(), SceneMotion::kGeneral);
  const CalibratedScene once = makeCalibratedScene(spec), again = makeCalibratedScene(spec);
  EXPECT_EQ(once.matches.right_x, again.matches.right_x);
  EXPECT_EQ(once.inlier, again.inlier);
  spec.distances = false;
  EXPECT_EQ(makeCalibratedScene(spec).matches.right_x, once.matches.right_x);
  EXPECT_TRUE(makeCalibratedScene(spec).matches.distance.empty());
  spec.seed = 1;
  EXPECT_NE(makeCalibratedScene(spec).matches.right_x, once.matches.right_x);
}

TEST(CalibratedScene, DistancesTellRightFromWrong) {
  const CalibratedScene scene = makeCalibratedScene(specOf(scenePinhole(), SceneMotion::kGeneral));
  double sums[2] = {};
  for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
    sums[scene.inlier[i]] += scene.matches.distance[i] / scene.matches.second_distance[i];
  }
  EXPECT_NEAR(sums[1] / 210, 0.60, 0.03);
  EXPECT_NEAR(sums[0] / 90, 0.78, 0.04);
}

TEST(CalibratedScene, CamerasNeedASize) {
  CalibratedSceneSpec spec;
  spec.right_camera.size = {};
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { makeCalibratedScene(spec); }),
                       "right_camera has no size"));
  spec.right_camera.matrix(0, 0) = -1;
  EXPECT_THROW(makeCalibratedScene(spec), std::invalid_argument);
}

}  // namespace
}  // namespace corrsel::core
