#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "corrsel/random.h"
#include "corrsel/relative_pose.h"
#include "geometry/essential.h"
#include "geometry/fundamental.h"
#include "kernels/kernels.h"
#include "pose_scene.h"

namespace corrsel::core {
namespace {

using namespace pose_scene;

TEST(Essential, MatrixOfTheExample) {
  const cv::Matx33d e = essentialOf(examplePose());
  const cv::Matx33d expected(0.068062383655, 0.182398218425, 0.284861406467, -0.274940406917, -0.048925973790,
                             -0.571643181097, -0.277631279216, 0.631740926121, -0.003840736327);
  EXPECT_LT(cv::norm(e * (1 / cv::norm(e)) - expected), 3e-12);
}

TEST(Essential, ErrorsOfTheExample) {
  constexpr double kExpected[8] = {0.433495023458, 0.458205784010, 0.082300393256, 0.571660536909,
                                   0.540387605441, 0.118044704845, 0.039905500577, 0.224650627675};
  const RayMatches matches = exampleMatches(1);
  const cv::Matx33d e = essentialOf(examplePose());
  double squared[8];
  squaredTangentSampson(e, matches, squared);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(std::abs(tangentSampson(e, matches, i)), kExpected[i], 2e-12);
    EXPECT_NEAR(std::sqrt(squared[i]), kExpected[i], 2e-12);
  }
}

TEST(Essential, DepthsOfTheExample) {
  const RayMatches matches = exampleMatches(1);
  const ScaledDepths depths =
      scaledDepths(examplePose(), matches.left.direction(0), matches.right.direction(0));
  EXPECT_NEAR(depths.left, 0.184950143478, 2e-12);
  EXPECT_NEAR(depths.right, 0.159327997115, 2e-12);
}

TEST(Essential, DepthsAreThoseOfTheTriangulatedPoint) {
  Random random(1);
  for (int round = 0; round < 20; ++round) {
    const Pose pose = randomPose(random);
    const cv::Vec3d left = randomDirection(random);
    const double z1 = random.uniform(0.5, 5);
    const cv::Vec3d point = pose.rotation * left * z1 + pose.translation;
    const double z2 = cv::norm(point);
    const double sine = std::sin(angleBetween(pose.rotation * left, point));
    const ScaledDepths depths = scaledDepths(pose, left, point / z2);
    EXPECT_NEAR(depths.left, z1 * sine * sine, 1e-12);
    EXPECT_NEAR(depths.right, z2 * sine * sine, 1e-12);
  }
}

TEST(Essential, OneOfTheFourPosesIsTheTrueOne) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    const Pose truth = randomPose(random);
    const double factor = random.uniform(-3, 3);
    const cv::Matx33d e = essentialOf(truth) * factor;
    Pose poses[4];
    ASSERT_TRUE(posesOf(e, poses));
    int found = 0;
    for (const Pose& pose : poses) {
      EXPECT_LT(cv::norm(pose.rotation * pose.rotation.t() - cv::Matx33d::eye()), 1e-12);
      EXPECT_NEAR(cv::determinant(pose.rotation), 1, 1e-12);
      EXPECT_NEAR(cv::norm(pose.translation), 1, 1e-12);
      const cv::Matx33d again = essentialOf(pose);
      EXPECT_NEAR(std::abs(again.dot(e)), cv::norm(again) * cv::norm(e), 1e-12);
      found += cv::norm(pose.rotation - truth.rotation) < 1e-12 &&
                       cv::norm(pose.translation - truth.translation) < 1e-12
                   ? 1
                   : 0;
    }
    EXPECT_EQ(found, 1);
    EXPECT_EQ(poses[0].translation, -poses[1].translation);
    EXPECT_EQ(poses[0].rotation, poses[1].rotation);
    EXPECT_EQ(poses[2].rotation, poses[3].rotation);
  }
}

TEST(Essential, NoPosesOfZeroOrNan) {
  Pose poses[4];
  EXPECT_FALSE(posesOf(cv::Matx33d::zeros(), poses));
  EXPECT_FALSE(posesOf(cv::Matx33d::all(std::numeric_limits<double>::quiet_NaN()), poses));
}

/// For pinholes the error is the Sampson distance of the fundamental matrix, but for a share of about r / f:
/// the length of (x, y, 1) differs along the gradient.
TEST(Essential, EqualsTheSampsonDistanceOfPinholes) {
  Random random(3);
  const Camera camera = pinhole();
  RelativePose relative;
  relative.left_camera = relative.right_camera = camera.matrix;
  const Pose pose = randomPose(random);
  relative.rotation = pose.rotation;
  relative.translation = pose.translation;
  const cv::Matx33d f = relative.fundamental();
  for (const double noise : {1e-6, 1e-3, 1.0, 5.0}) {
    for (int i = 0; i < 100; ++i) {
      const double depth = random.uniform(4, 12);
      const double u = random.uniform(200, 1000);
      const double v = random.uniform(200, 700);
      Ray ray;
      cv::Point2d right;
      ASSERT_TRUE(unproject(camera, {u, v}, ray));
      ASSERT_TRUE(project(camera, pose.rotation * ray.direction * depth + pose.translation, right));
      right = noisy(right, noise, random);
      RayMatches matches;
      ASSERT_TRUE(append(camera, {u, v}, right, matches));
      const double r = std::abs(tangentSampson(essentialOf(pose), matches, 0));
      const double expected = std::sqrt(sampsonError(f, u, v, right.x, right.y));
      EXPECT_NEAR(r, expected, r * r / 600 + 1e-10);
    }
  }
}

/// Noise of 1 px on all coordinates makes errors of 1 px, for rays in all directions.
TEST(Essential, IsTheDistanceInPixelsForEveryCamera) {
  Random random(4);
  for (const Camera& camera : cameras()) {
    const Pose pose = randomPose(random);
    const RayMatches exact = generated(camera, pose, 1.2, 0, 200, random);
    const RayMatches near = generated(camera, pose, 1.2, 1, 2000, random);
    double sum = 0;
    for (std::size_t i = 0; i < near.size(); ++i) {
      const double r = tangentSampson(essentialOf(pose), near, i);
      sum += r * r;
    }
    EXPECT_NEAR(sum / 2000, 1, 0.12);  // chi^2 of one degree of freedom: standard deviation 0.03
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_NEAR(tangentSampson(essentialOf(pose), exact, i), 0, 1e-9);
    }
  }
}

TEST(Essential, AgreesAtTheEpipole) {
  const Pose forward{cv::Matx33d::eye(), {0, 0, 1}};
  RayMatches matches;
  ASSERT_TRUE(append(pinhole(), {639.5, 479.5}, {639.5, 479.5}, matches));
  EXPECT_EQ(tangentSampson(essentialOf(forward), matches, 0), 0);
}

TEST(Essential, MissingRaysAreNan) {
  RayMatches matches = exampleMatches(1);
  matches.right.column[4][3] = std::numeric_limits<double>::quiet_NaN();
  double squared[8];
  squaredTangentSampson(essentialOf(examplePose()), matches, squared);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(std::isnan(squared[i]), i == 3);
}

TEST(Essential, FarPointsAreInFrontWithinTheirNoise) {
  // At infinity the rays are parallel; here they diverge by half a pixel.
  RayMatches matches;
  ASSERT_TRUE(append(pinhole(), {639.5, 479.5}, {639, 479.5}, matches));
  const Pose pose{cv::Matx33d::eye(), {1, 0, 0}};
  EXPECT_TRUE(isInFront(pose, matches, 0, 1));
  EXPECT_FALSE(isInFront(pose, matches, 0, 0.1));
  EXPECT_TRUE(isInFront({cv::Matx33d::eye(), {-1, 0, 0}}, matches, 0, 0));
}

TEST(Essential, ChoosesTheTruePose) {
  Random random(5);
  for (const Camera& camera : cameras()) {
    for (int round = 0; round < 5; ++round) {
      const Pose truth = randomPose(random);
      const RayMatches matches = generated(camera, truth, 1.2, 0.5, 150, random);
      Pose pose;
      ASSERT_TRUE(choosePose(essentialOf(truth) * -2.0, matches, 2, pose));
      EXPECT_LT(cv::norm(pose.rotation - truth.rotation), 1e-9);
      EXPECT_LT(cv::norm(pose.translation - truth.translation), 1e-9);
    }
  }
}

TEST(Essential, ChoosesNoPoseWithoutAgreementOrWithoutDepth) {
  Random random(6);
  const Pose truth = randomPose(random);
  const RayMatches matches = generated(pinhole(), truth, 1.2, 1, 100, random);
  Pose pose;
  EXPECT_FALSE(choosePose(essentialOf(truth), matches, 1e-9, pose));
  EXPECT_TRUE(choosePose(essentialOf(truth), matches, 3, pose));
  // A third of the points each lies in front of both cameras, of one of them, and of none.
  RayMatches mixed = matches;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 100; ++i) {
      if (i % 3 != 0) mixed.right.column[k][i] *= -1;
      if (i % 3 == 2) mixed.left.column[k][i] *= -1;
    }
  }
  EXPECT_FALSE(choosePose(essentialOf(truth), mixed, 3, pose));
}

TEST(Essential, SameBitsAtEveryLevel) {
  Random random(7);
  const Pose pose = randomPose(random);
  const RayMatches matches = generated(fisheye(), pose, 1.2, 1, 61, random);
  const KernelLevel before = kernelLevel();
  setKernelLevel(KernelLevel::kPlain);
  std::vector<double> expected(matches.size());
  squaredTangentSampson(essentialOf(pose), matches, expected.data());
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    std::vector<double> squared(matches.size() + 1, -1);
    squaredTangentSampson(essentialOf(pose), matches, squared.data());
    EXPECT_EQ(squared.back(), -1);
    squared.pop_back();
    EXPECT_EQ(squared, expected) << toString(level);
  }
  setKernelLevel(before);
}

}  // namespace
}  // namespace corrsel::core
