#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <vector>

#include "geometry/cross_matrix.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"
#include "kernels/kernels.h"
#include "pose_scene.h"

namespace corrsel::core {
namespace {

using namespace pose_scene;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

cv::Vec<double, 5> unitStep(int k, double length) {
  cv::Vec<double, 5> step;
  step[k] = length;
  return step;
}

/// A pose near the given one.
Pose disturbed(const Pose& pose, double amount, Random& random) {
  cv::Vec<double, 5> step;
  for (int k = 0; k < 5; ++k) step[k] = random.uniform(-amount, amount);
  return moved(pose, step);
}

/// The error of an estimated pose in the parameters of its covariance.
cv::Vec<double, 5> errorOf(const Pose& pose, const Pose& truth) {
  const cv::Matx33d difference = truth.rotation * pose.rotation.t();
  cv::Vec3d b1, b2;
  translationBasis(pose.translation, b1, b2);
  const cv::Vec3d t = truth.translation / truth.translation.dot(pose.translation);
  return {0.5 * (difference(2, 1) - difference(1, 2)), 0.5 * (difference(0, 2) - difference(2, 0)),
          0.5 * (difference(1, 0) - difference(0, 1)), t.dot(b1), t.dot(b2)};
}

double squaredMahalanobis(const cv::Vec<double, 5>& error, const cv::Matx<double, 5, 5>& covariance) {
  return error.dot(covariance.inv(cv::DECOMP_CHOLESKY) * error);
}

TEST(PoseFit, BasisOfTheExample) {
  cv::Vec3d b1, b2;
  translationBasis(examplePose().translation, b1, b2);
  EXPECT_LT(cv::norm(b1 - cv::Vec3d(0.447213595500, -0.894427191000, 0)), 2e-12);
  EXPECT_LT(cv::norm(b2 - cv::Vec3d(-0.195180014590, -0.097590007295, -0.975900072949)), 2e-12);
}

TEST(PoseFit, BasisIsOrthonormalAlsoAlongAnAxis) {
  Random random(1);
  std::vector<cv::Vec3d> directions = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  for (int i = 0; i < 20; ++i) directions.push_back(randomDirection(random));
  for (const cv::Vec3d& t : directions) {
    cv::Vec3d b1, b2;
    translationBasis(t, b1, b2);
    const cv::Matx33d basis(b1[0], b2[0], t[0], b1[1], b2[1], t[1], b1[2], b2[2], t[2]);
    EXPECT_LT(cv::norm(basis.t() * basis - cv::Matx33d::eye()), 1e-14);
    EXPECT_NEAR(cv::determinant(basis), 1, 1e-14);
  }
  cv::Vec3d b1, b2;
  translationBasis({1, 0, 0}, b1, b2);  // y is the first of the smallest
  EXPECT_EQ(b1, cv::Vec3d(0, 0, 1));
}

TEST(PoseFit, MovedStaysAPose) {
  Random random(2);
  for (const double length : {1e-9, 1e-5, 0.1, 3.0}) {
    const Pose start = randomPose(random);
    const cv::Vec3d axis = randomDirection(random);
    const cv::Vec3d w = axis * length;
    const Pose pose = moved(start, {w[0], w[1], w[2], 0.3, -0.2});
    EXPECT_LT(cv::norm(pose.rotation * pose.rotation.t() - cv::Matx33d::eye()), 1e-14);
    EXPECT_NEAR(cv::norm(pose.translation), 1, 1e-15);
    const cv::Matx33d turned = pose.rotation * start.rotation.t();
    EXPECT_LT(cv::norm(turned * axis - axis), 1e-14);
    const cv::Vec3d sine(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0),
                         turned(1, 0) - turned(0, 1));
    EXPECT_NEAR(0.5 * axis.dot(sine), std::sin(length), 1e-14 * length + 1e-16);
  }
}

TEST(PoseFit, SumsOfTheExample) {
  constexpr double kHessian[15] = {895559.343154, 440422.802231, 225339.599329, 210641.499203, 103690.575754,
                                   94144.379287,  194949.750945, 99793.220364,  49104.491330,  45808.988687,
                                   24.239167,     -4085.875582,  -1721.056715,  -1892.717372,  2061.083082};
  const cv::Vec<double, 5> gradient(-121.606309843, -100.651145419, 10.493777340, -23.200619359,
                                    18.537740681);
  const PoseSums sums = poseSums(examplePose(), exampleMatches(1), kInfinity);
  EXPECT_NEAR(sums.cost, 1.089453270000, 2e-12);
  EXPECT_LT(cv::norm(sums.gradient - gradient), 5e-9);
  for (int i = 0, k = 0; i < 5; ++i) {
    for (int j = 0; j <= i; ++j, ++k) {
      EXPECT_NEAR(sums.hessian(i, j), kHessian[k], 2e-6) << i << ' ' << j;
      EXPECT_EQ(sums.hessian(i, j), sums.hessian(j, i));
    }
  }
}

/// The sums of one match give its r and J, which must be the derivative of r.
TEST(PoseFit, DerivativesOfSingleMatches) {
  constexpr double kStep = 1e-6;
  Random random(3);
  int behind = 0;
  for (const Camera& camera : cameras()) {
    const Pose truth = randomPose(random);
    const Pose pose = disturbed(truth, 0.01, random);
    const RayMatches all = generated(camera, truth, 1.2, 1, 30, random);
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      RayMatches one;
      append({all.left.direction(i), all.left.jacobian(i)}, one.left);
      append({all.right.direction(i), all.right.jacobian(i)}, one.right);
      behind += one.left.direction(0)[2] < 0 ? 1 : 0;
      const double r = tangentSampson(essentialOf(pose), one, 0);
      const PoseSums sums = poseSums(pose, one, kInfinity);
      for (int k = 0; k < 5; ++k) {
        const double plus = tangentSampson(essentialOf(moved(pose, unitStep(k, kStep))), one, 0);
        const double minus = tangentSampson(essentialOf(moved(pose, unitStep(k, -kStep))), one, 0);
        EXPECT_NEAR(sums.gradient[k] / r, (plus - minus) / (2 * kStep), 1e-3)
            << toString(camera.model) << ' ' << i << ' ' << k;
        EXPECT_NEAR(sums.hessian(k, k) * r * r, sums.gradient[k] * sums.gradient[k],
                    1e-9 * sums.hessian(k, k) * r * r);
      }
    }
  }
  EXPECT_GT(behind, 10);
}

TEST(PoseFit, GradientOfTheLoss) {
  constexpr double kStep = 1e-7;
  Random random(4);
  for (const Camera& camera : cameras()) {
    for (const double scale : {0.5, 3.0, kInfinity}) {
      const Pose truth = randomPose(random);
      const RayMatches matches = generated(camera, truth, 1.2, 1, 101, random);
      const Pose pose = disturbed(truth, 0.002, random);
      const PoseSums sums = poseSums(pose, matches, scale);
      const double size = std::sqrt(sums.cost * cv::trace(sums.hessian));
      for (int k = 0; k < 5; ++k) {
        const double plus = poseSums(moved(pose, unitStep(k, kStep)), matches, scale).cost;
        const double minus = poseSums(moved(pose, unitStep(k, -kStep)), matches, scale).cost;
        EXPECT_NEAR(2 * sums.gradient[k], (plus - minus) / (2 * kStep), 1e-5 * size);
      }
    }
  }
}

TEST(PoseFit, SumsAreThoseOfTheirParts) {
  Random random(5);
  const Pose pose = randomPose(random);
  const RayMatches matches = generated(fisheye(), pose, 1.2, 1, 37, random);
  for (const std::size_t n : {0, 1, 7, 8, 9, 15, 16, 17, 37}) {
    PoseSums expected;
    RayMatches first;
    for (std::size_t i = 0; i < n; ++i) {
      RayMatches one;
      for (RayMatches* const to : {&one, &first}) {
        append({matches.left.direction(i), matches.left.jacobian(i)}, to->left);
        append({matches.right.direction(i), matches.right.jacobian(i)}, to->right);
      }
      const PoseSums sums = poseSums(pose, one, 2);
      expected.cost += sums.cost;
      expected.gradient += sums.gradient;
      expected.hessian += sums.hessian;
    }
    const PoseSums sums = poseSums(pose, first, 2);
    EXPECT_NEAR(sums.cost, expected.cost, 1e-12 * expected.cost);
    EXPECT_LE(cv::norm(sums.gradient - expected.gradient), 1e-9 * cv::norm(expected.hessian));
    EXPECT_LE(cv::norm(sums.hessian - expected.hessian), 1e-12 * cv::norm(expected.hessian));
  }
}

TEST(PoseFit, LeastSquaresOfTheExample) {
  Pose pose = examplePose();
  EXPECT_NEAR(fitPose(exampleMatches(1), kInfinity, 50, pose), 0.591696997919, 2e-12);
  const cv::Matx33d rotation(0.980784962760, -0.058516765996, -0.186109228468, 0.039908135400, 0.993962043262,
                             -0.102209575305, 0.190966482799, 0.092818342220, 0.977198320606);
  EXPECT_LT(cv::norm(pose.rotation - rotation), 1e-7);
  EXPECT_LT(cv::norm(pose.translation - cv::Vec3d(0.867152339670, 0.448722702822, -0.216089693826)), 1e-7);
}

TEST(PoseFit, FindsTheExactPose) {
  Random random(6);
  for (const Camera& camera : cameras()) {
    const Pose truth = randomPose(random);
    const RayMatches matches = generated(camera, truth, 1.2, 0, 50, random);
    Pose pose = disturbed(truth, 0.02, random);
    EXPECT_LT(fitPose(matches, 100, 30, pose), 1e-12);
    EXPECT_LT(cv::norm(errorOf(pose, truth)), 1e-9);
  }
}

TEST(PoseFit, WrongMatchesHardlyCount) {
  Random random(7);
  const Pose truth = randomPose(random);
  RayMatches matches = generated(pinhole(), truth, 1.2, 0.5, 400, random);
  for (std::size_t i = 0; i < 40; ++i) {
    const double x = random.uniform(0, 1280);
    const double y = random.uniform(0, 960);
    ASSERT_TRUE(append(pinhole(), {y, x}, {x, y}, matches));
  }
  Pose robust = truth, plain = truth;
  EXPECT_GT(fitPose(matches, 1, 20, robust), 0);
  EXPECT_GT(fitPose(matches, kInfinity, 20, plain), 0);
  EXPECT_LT(cv::norm(errorOf(robust, truth)), 0.01);
  EXPECT_GT(cv::norm(errorOf(plain, truth)), 0.05);
}

TEST(PoseFit, RestoresTheSignOfTheTranslation) {
  Random random(8);
  for (const Camera& camera : cameras()) {
    const Pose truth = randomPose(random);
    const RayMatches matches = generated(camera, truth, 1.2, 0.5, 200, random);
    Pose pose = disturbed(truth, 0.01, random);
    pose.translation = -pose.translation;
    EXPECT_GT(fitPose(matches, 1, 20, pose), 0);
    EXPECT_GT(pose.translation.dot(truth.translation), 0.99);
  }
}

TEST(PoseFit, PointsOnOneLineDoNotDetermineThePose) {
  Random random(9);
  const Pose truth{cv::Matx33d::eye(), cv::normalize(cv::Vec3d(1, 0, 0.3))};
  RayMatches matches;
  for (int i = 0; i < 50; ++i) {
    const double x = random.uniform(-3, 3);
    const double z = random.uniform(4, 12);
    cv::Point2d left, right;
    ASSERT_TRUE(project(pinhole(), {x, 0, z}, left));
    ASSERT_TRUE(project(pinhole(), cv::Vec3d(x, 0, z) + truth.translation, right));
    append(pinhole(), left, right, matches);
  }
  Pose pose = truth;
  EXPECT_TRUE(std::isnan(fitPose(matches, 1, 8, pose)));
  EXPECT_EQ(pose.rotation, truth.rotation);
  EXPECT_EQ(pose.translation, truth.translation);
  cv::Matx<double, 5, 5> covariance;
  EXPECT_FALSE(poseCovariance(truth, matches, 1, covariance));
}

TEST(PoseFit, MissingRaysAreNoFit) {
  RayMatches matches = exampleMatches(1);
  matches.left.column[0][2] = std::numeric_limits<double>::quiet_NaN();
  Pose pose = examplePose();
  EXPECT_TRUE(std::isnan(fitPose(matches, 1, 8, pose)));
}

TEST(PoseFit, CovarianceNeedsMoreMatchesThanParameters) {
  Random random(10);
  const Pose truth = randomPose(random);
  cv::Matx<double, 5, 5> covariance;
  EXPECT_FALSE(poseCovariance(truth, generated(pinhole(), truth, 1.2, 1, 5, random), 2, covariance));
  EXPECT_TRUE(poseCovariance(truth, generated(pinhole(), truth, 1.2, 1, 6, random), 2, covariance));
  EXPECT_EQ(covariance, covariance.t());
}

/// Squared errors in units of the covariance have the mean 5, and 95 % are below 11.07, the quantile of the
/// chi-squared distribution.
TEST(PoseFit, CovarianceHolds) {
  constexpr int kScenes = 1200;
  Random random(11);
  double sum = 0;
  int inside = 0;
  for (int scene = 0; scene < kScenes; ++scene) {
    const Camera camera = cameras()[static_cast<std::size_t>(scene % 3)];
    const Pose truth = randomPose(random);
    const RayMatches matches = generated(camera, truth, 1.2, 1, 400, random);
    Pose pose = truth;
    ASSERT_GT(fitPose(matches, 2.5, 20, pose), 0);
    cv::Matx<double, 5, 5> covariance;
    ASSERT_TRUE(poseCovariance(pose, matches, 2.5, covariance));
    const double nees = squaredMahalanobis(errorOf(pose, truth), covariance);
    sum += nees;
    inside += nees < 11.0705 ? 1 : 0;
  }
  RecordProperty("nees", std::to_string(sum / kScenes));
  RecordProperty("inside", inside);
  EXPECT_GT(sum / kScenes, 4.6);
  EXPECT_LT(sum / kScenes, 5.4);
  EXPECT_GE(inside, kScenes * 0.93);
  EXPECT_LE(inside, kScenes * 0.97);
}

TEST(PoseFit, KnownRotationStaysAsItIs) {
  Random random(12);
  const Pose truth = randomPose(random);
  const RayMatches matches = generated(pinhole(), truth, 1.2, 0.5, 200, random);
  Pose pose = moved(truth, {0, 0, 0, 0.1, -0.1});
  EXPECT_GT(fitPose(matches, 2, 20, pose, PoseFreedom::translation()), 0);
  EXPECT_EQ(pose.rotation, truth.rotation);
  EXPECT_LT(angleBetween(pose.translation, truth.translation), 0.01);
  cv::Matx<double, 5, 5> covariance;
  ASSERT_TRUE(poseCovariance(pose, matches, 2, covariance, PoseFreedom::translation()));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 5; ++j) EXPECT_EQ(covariance(i, j), 0);
  }
  EXPECT_GT(covariance(3, 3), 0);
  EXPECT_GT(covariance(4, 4), 0);
}

TEST(PoseFit, KnownVerticalStaysAsItIs) {
  Random random(13);
  const Pose truth = randomPose(random);
  const cv::Vec3d left_up = randomDirection(random);
  const cv::Vec3d right_up = truth.rotation * left_up;
  const RayMatches matches = generated(pinhole(), truth, 1.2, 0.5, 200, random);
  const cv::Vec3d w = right_up * 0.05;
  Pose pose = moved(truth, {w[0], w[1], w[2], 0.05, -0.05});
  EXPECT_GT(fitPose(matches, 2, 20, pose, PoseFreedom::about(right_up)), 0);
  EXPECT_LT(cv::norm(pose.rotation * left_up - right_up), 1e-13);
  EXPECT_LT(cv::norm(errorOf(pose, truth)), 0.01);
  cv::Matx<double, 5, 5> covariance, unknown;
  ASSERT_TRUE(poseCovariance(pose, matches, 2, covariance, PoseFreedom::about(right_up)));
  ASSERT_TRUE(poseCovariance(pose, matches, 2, unknown));
  const cv::Matx33d rotation = covariance.get_minor<3, 3>(0, 0);
  const cv::Matx33d expected = right_up * right_up.t() * cv::trace(rotation);
  EXPECT_LT(cv::norm(rotation - expected), 1e-12 * cv::norm(rotation));
  EXPECT_LT(cv::trace(covariance), cv::trace(unknown));
}

TEST(PoseFit, PosesOfThePlaneOfTheExample) {
  const Pose truth = examplePose();
  const cv::Vec3d n(0.05, -0.1, 0.2);
  const cv::Matx33d h = truth.rotation + truth.translation * n.t();
  Random random(14);
  RayMatches matches;
  for (int i = 0; i < 20; ++i) {
    const double u = random.uniform(100, 500);
    const double v = random.uniform(100, 400);
    Ray left;
    cv::Point2d right;
    ASSERT_TRUE(unproject(exampleCamera(), {u, v}, left));
    ASSERT_TRUE(project(exampleCamera(), h * left.direction, right));
    append(exampleCamera(), {u, v}, right, matches);
  }
  const cv::Matx33d other(0.987135618114, -0.159706797978, -0.007550505285, 0.159067836856, 0.985762569600,
                          -0.054493849693, 0.016146043735, 0.052591777457, 0.998485558341);
  const cv::Vec3d other_t(-0.040026822324, 0.110553982759, -0.196661308830);
  for (const double factor : {1.0, -0.3}) {
    PlanePose poses[2];
    ASSERT_TRUE(posesOfPlane(h * factor, matches, poses));
    const int first = cv::norm(poses[0].pose.rotation - truth.rotation) < 1e-6 ? 0 : 1;
    const PlanePose &given = poses[first], &second = poses[1 - first];
    EXPECT_LT(cv::norm(given.pose.rotation - truth.rotation), 1e-11);
    EXPECT_LT(cv::norm(given.pose.translation - truth.translation), 1e-11);
    EXPECT_LT(cv::norm(given.normal - n), 1e-11);
    EXPECT_LT(cv::norm(second.pose.rotation - other), 1e-11);
    // The example states the pose with the other sign of t and n, for which no match lies in front.
    EXPECT_NEAR(std::abs(second.pose.translation.dot(cv::normalize(other_t))), 1, 1e-11);
    EXPECT_NEAR(cv::norm(second.normal), cv::norm(other_t), 1e-11);
    EXPECT_LT(cv::norm(second.pose.rotation + second.pose.translation * second.normal.t() - h), 1e-11);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      EXPECT_TRUE(isInFront(given.pose, matches, i, 0));
      EXPECT_GT(given.normal.dot(matches.left.direction(i)), 0);
    }
  }
}

TEST(PoseFit, EigenvaluesOfThePlaneOfTheExample) {
  const cv::Matx33d h = examplePose().rotation + examplePose().translation * cv::Vec3d(0.05, -0.1, 0.2).t();
  cv::Vec3d values;
  cv::eigen(h.t() * h, values);
  EXPECT_LT(cv::norm(values - cv::Vec3d(1.166971834219, 1, 0.724432355808)), 2e-12);
}

TEST(PoseFit, PosesOfRandomPlanes) {
  Random random(15);
  for (int round = 0; round < 100; ++round) {
    const Pose truth = randomPose(random);
    const cv::Vec3d direction = randomDirection(random);
    const double distance = random.uniform(2, 10);
    const cv::Vec3d n = direction / distance;
    RayMatches matches;
    for (int i = 0; i < 20;) {
      const cv::Vec3d left = randomDirection(random);
      if (left.dot(n) < 0.02) continue;
      append({left, {}}, matches.left);
      append({cv::normalize(truth.rotation * left + truth.translation * left.dot(n)), {}}, matches.right);
      ++i;
    }
    PlanePose poses[2];
    ASSERT_TRUE(posesOfPlane((truth.rotation + truth.translation * n.t()) * 5.0, matches, poses));
    double error = kInfinity;
    for (const PlanePose& pose : poses) {
      EXPECT_LT(cv::norm(pose.pose.rotation * pose.pose.rotation.t() - cv::Matx33d::eye()), 1e-8);
      EXPECT_NEAR(cv::determinant(pose.pose.rotation), 1, 1e-8);
      error = std::min(error, cv::norm(pose.pose.rotation - truth.rotation) +
                                  cv::norm(pose.pose.translation - truth.translation) +
                                  cv::norm(pose.normal - n));
    }
    EXPECT_LT(error, 1e-7);
  }
}

TEST(PoseFit, NoPlaneOfARotationOrOfASingularMatrix) {
  const RayMatches matches = exampleMatches(0);
  PlanePose poses[2];
  EXPECT_FALSE(posesOfPlane(examplePose().rotation * 3.0, matches, poses));
  EXPECT_FALSE(posesOfPlane(cv::Matx33d(1, 0, 0, 0, 1, 0, 0, 0, 0), matches, poses));
  EXPECT_FALSE(posesOfPlane(cv::Matx33d::all(std::numeric_limits<double>::quiet_NaN()), matches, poses));
}

TEST(PoseFit, MotionAlongTheNormalGivesOnePose) {
  const RayMatches matches = exampleMatches(0);
  const Pose truth{examplePose().rotation, examplePose().rotation * cv::Vec3d(0, 0, 1)};
  const cv::Vec3d n(0, 0, 0.1);
  PlanePose poses[2];
  ASSERT_TRUE(posesOfPlane(truth.rotation + truth.translation * n.t(), matches, poses));
  for (const PlanePose& pose : poses) {
    EXPECT_LT(cv::norm(pose.pose.rotation - truth.rotation), 1e-7);
    EXPECT_LT(cv::norm(pose.pose.translation - truth.translation), 1e-6);
    EXPECT_LT(cv::norm(pose.normal - n), 1e-6);
  }
}

TEST(PoseFit, SameBitsAtEveryLevel) {
  Random random(16);
  const Pose truth = randomPose(random);
  const RayMatches matches = generated(fisheye(), truth, 1.2, 1, 61, random);
  const Pose start = disturbed(truth, 0.01, random);
  const KernelLevel before = kernelLevel();
  setKernelLevel(KernelLevel::kPlain);
  const PoseSums expected = poseSums(start, matches, 2);
  Pose expected_pose = start;
  const double expected_loss = fitPose(matches, 2, 8, expected_pose);
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    const PoseSums sums = poseSums(start, matches, 2);
    EXPECT_EQ(sums.cost, expected.cost) << toString(level);
    EXPECT_EQ(sums.gradient, expected.gradient) << toString(level);
    EXPECT_EQ(sums.hessian, expected.hessian) << toString(level);
    Pose pose = start;
    EXPECT_EQ(fitPose(matches, 2, 8, pose), expected_loss) << toString(level);
    EXPECT_EQ(pose.rotation, expected_pose.rotation) << toString(level);
    EXPECT_EQ(pose.translation, expected_pose.translation) << toString(level);
  }
  setKernelLevel(before);
}

}  // namespace
}  // namespace corrsel::core
