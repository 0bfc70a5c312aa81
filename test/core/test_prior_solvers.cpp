#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/core.hpp>

#include "corrsel/random.h"
#include "geometry/essential.h"
#include "geometry/prior_solvers.h"
#include "pose_scene.h"

namespace corrsel::core {
namespace {

using namespace pose_scene;

/// Exact rays of points in front of both cameras, which look in all directions.
template <int count>
struct Sample {
  cv::Vec3d left[count], right[count];

  Sample(const Pose& pose, Random& random) {
    for (int i = 0; i < count; ++i) {
      left[i] = randomDirection(random);
      const double depth = random.uniform(1, 10);
      right[i] = cv::normalize(pose.rotation * left[i] * depth + pose.translation);
    }
  }
};

Pose turnedAbout(const cv::Vec3d& axis, double angle, const cv::Vec3d& t) {
  const cv::Vec3d w = axis * angle;
  return moved({cv::Matx33d::eye(), t}, {w[0], w[1], w[2], 0, 0});
}

double difference(const Pose& a, const Pose& b) {
  return cv::norm(a.rotation - b.rotation) + cv::norm(a.translation - b.translation);
}

/// Checks that the poses fit the sample and the vertical, and returns the smallest difference from the truth.
double checkPoses(const cv::Vec3d& left_up, const cv::Vec3d& right_up, const Sample<3>& sample,
                  const Pose& truth) {
  Pose poses[kVerticalSolutions];
  const int count = posesFromThree(left_up, right_up, sample.left, sample.right, poses);
  double smallest = 1e9;
  for (int k = 0; k < count; ++k) {
    EXPECT_LT(cv::norm(poses[k].rotation * left_up - right_up), 1e-12);
    EXPECT_LT(cv::norm(poses[k].rotation * poses[k].rotation.t() - cv::Matx33d::eye()), 1e-12);
    EXPECT_NEAR(cv::norm(poses[k].translation), 1, 1e-12);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(sample.right[i].dot(essentialOf(poses[k]) * sample.left[i]), 0, 1e-6);
    }
    smallest = std::min(smallest, difference(poses[k], truth));
  }
  return smallest;
}

TEST(PriorSolvers, TranslationOfTheExample) {
  const RayMatches matches = exampleMatches(0);
  const cv::Vec3d left[2] = {matches.left.direction(0), matches.left.direction(1)};
  const cv::Vec3d right[2] = {matches.right.direction(0), matches.right.direction(1)};
  cv::Vec3d t;
  ASSERT_TRUE(translationFromTwo(examplePose().rotation, left, right, t));
  EXPECT_LT(cv::norm(t - cv::Vec3d(0.872871560944, 0.436435780472, -0.218217890236)), 2e-12);
}

TEST(PriorSolvers, TranslationOfRandomPoses) {
  Random random(1);
  for (int round = 0; round < 200; ++round) {
    const Pose truth = randomPose(random);
    const Sample<2> sample(truth, random);
    cv::Vec3d t;
    ASSERT_TRUE(translationFromTwo(truth.rotation, sample.left, sample.right, t));
    EXPECT_LT(cv::norm(t - truth.translation), 1e-9);
  }
}

TEST(PriorSolvers, NoTranslationOfMatchesThatDoNotMoveOrShareAPlane) {
  Random random(2);
  const Pose truth = randomPose(random);
  Sample<2> sample(truth, random);
  cv::Vec3d t;
  sample.left[1] = sample.left[0];
  sample.right[1] = sample.right[0];
  EXPECT_FALSE(translationFromTwo(truth.rotation, sample.left, sample.right, t));
  const cv::Vec3d left[2] = {{0, 0, 1}, cv::normalize(cv::Vec3d(0.3, 0.2, 1))};
  EXPECT_FALSE(translationFromTwo(cv::Matx33d::eye(), left, left, t));
}

TEST(PriorSolvers, KnownVerticalOfTheExample) {
  const RayMatches matches = exampleMatches(0);
  const Pose truth = examplePose();
  Random random(3);
  const cv::Vec3d up = randomDirection(random);
  Sample<3> sample(truth, random);
  for (std::size_t i = 0; i < 3; ++i) {
    sample.left[i] = matches.left.direction(i);
    sample.right[i] = matches.right.direction(i);
  }
  EXPECT_LT(checkPoses(up, truth.rotation * up, sample, truth), 1e-9);
}

TEST(PriorSolvers, KnownVerticalOfRandomPoses) {
  Random random(4);
  int found = 0;
  for (int round = 0; round < 1000; ++round) {
    const cv::Vec3d up = randomDirection(random);
    const cv::Vec3d axis = randomDirection(random);
    const double angle = random.uniform(0, CV_PI);
    const cv::Vec3d t = randomDirection(random);
    const Pose truth = turnedAbout(axis, angle, t);
    const Sample<3> sample(truth, random);
    found += checkPoses(up, truth.rotation * up, sample, truth) < 1e-6 ? 1 : 0;
  }
  EXPECT_GE(found, 998);  // rounding decides where two roots are nearly equal
}

/// Turns by nothing and by half a turn, and motion along the vertical, which leaves both.
TEST(PriorSolvers, KnownVerticalOfSpecialMotions) {
  Random random(5);
  const cv::Vec3d up(0, -1, 0);
  for (const double angle : {0.0, 0.5 * CV_PI, CV_PI, -0.5 * CV_PI}) {
    for (const cv::Vec3d& t : {cv::Vec3d(0, 1, 0), cv::Vec3d(0, 0, 1), cv::Vec3d(-1, 0, 0)}) {
      const Pose truth = turnedAbout(up, angle, t);
      const Sample<3> sample(truth, random);
      EXPECT_LT(checkPoses(up, up, sample, truth), 1e-6) << angle << ' ' << t;
    }
  }
}

TEST(PriorSolvers, EqualMatchesHaveNoPose) {
  Random random(6);
  const Pose truth = randomPose(random);
  Sample<3> sample(truth, random);
  sample.left[2] = sample.left[1];
  sample.right[2] = sample.right[1];
  const cv::Vec3d up(0, -1, 0);
  Pose poses[kVerticalSolutions];
  EXPECT_EQ(posesFromThree(up, truth.rotation * up, sample.left, sample.right, poses), 0);
  sample.left[2] = cv::Vec3d::all(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(posesFromThree(up, truth.rotation * up, sample.left, sample.right, poses), 0);
}

}  // namespace
}  // namespace corrsel::core
