#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calibrated_scene.h"
#include "corrsel/pose_prior.h"
#include "corrsel/random.h"
#include "corrsel/selectors/pose.h"
#include "geometry/essential.h"
#include "geometry/known_motion.h"
#include "geometry/rays.h"
#include "geometry/rotation.h"

namespace corrsel::core {
namespace {

using namespace calibrated_scene;
using pose_scene::angleBetween;
using pose_scene::randomDirection;

using Vec5 = cv::Vec<double, 5>;

enum class Known { kRotation, kVertical, kRig };

constexpr double kNoise = 0.5;  // px

PosePrior priorOf(Known known, const Pose& truth, Random& random) {
  if (known == Known::kRotation) return PosePrior::ofRotation(truth.rotation);
  if (known == Known::kRig) return PosePrior::ofRig(truth.rotation, truth.translation);
  const cv::Vec3d left = randomDirection(random);
  return PosePrior::ofVertical(left, truth.rotation * left);
}

/// A scene whose matches have a prior.
Scene knownScene(Known known, SceneOptions options, std::uint64_t seed) {
  options.noise = kNoise;
  Scene scene = generate(options, seed);
  Random random(seed + 1000);
  scene.matches.prior = priorOf(known, scene.truth, random);
  return scene;
}

/// w of the rotation exp([w]_x) by a small angle.
cv::Vec3d vectorOf(const cv::Matx33d& r) {
  return cv::Vec3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)) * 0.5;
}

/// The error in the parameters of the covariance.
Vec5 errorOf(const Pose& found, const Pose& truth) {
  const cv::Vec3d w = vectorOf(truth.rotation * found.rotation.t());
  cv::Vec3d b1, b2;
  translationBasis(found.translation, b1, b2);
  const double along = truth.translation.dot(found.translation);
  return {w[0], w[1], w[2], b1.dot(truth.translation) / along, b2.dot(truth.translation) / along};
}

/// e^T C^-1 e in the free directions, whose expected value is their number.
template <int size>
double normalisedError(const PoseResult& found, const Pose& truth, const PoseFreedom& freedom) {
  cv::Matx<double, size, size> covariance;
  cv::Vec<double, size> error;
  const Vec5 full = errorOf(found.pose, truth);
  for (int i = 0; i < size; ++i) {
    error[i] = freedom.directions[i].dot(full);
    for (int j = 0; j < size; ++j)
      covariance(i, j) = freedom.directions[i].dot(found.covariance * freedom.directions[j]);
  }
  return error.dot(covariance.inv() * error);
}

template <int size>
double meanNormalisedError(Known known) {
  constexpr int kScenes = 100;
  double sum = 0;
  for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
    SceneOptions options;
    options.right_share = 0.7;
    const Scene scene = knownScene(known, options, seed);
    const Selection found = PoseSelector().select(scene.matches);
    EXPECT_EQ(found.status, Status::kOk);
    if (!found.pose) return -1;
    EXPECT_FALSE(found.pose->uncertain);
    sum += normalisedError<size>(*found.pose, scene.truth, freedomOf(scene.matches.prior));
  }
  return sum / kScenes;
}

/// Searches among matches of which a fifth is right. @return samples in the mean
double meanSamples(Known known) {
  constexpr int kScenes = 20;
  double samples = 0;
  for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
    SceneOptions options;
    options.size = 500;
    options.right_share = 0.2;
    const Scene scene = knownScene(known, options, seed);
    const Selection found = PoseSelector().select(scene.matches);
    EXPECT_EQ(found.status, Status::kOk) << found.message;
    if (!found.pose) return -1;
    EXPECT_LT(cv::norm(vectorOf(scene.truth.rotation * found.pose->pose.rotation.t())), 0.005);
    EXPECT_LT(angleBetween(found.pose->pose.translation, scene.truth.translation), 0.03);
    samples += found.iterations;
  }
  return samples / kScenes;
}

TEST(PriorModels, FewSamplesSufficeAtAFifthOfRightMatches) {
  const double rotation = meanSamples(Known::kRotation), vertical = meanSamples(Known::kVertical);
  EXPECT_GT(rotation, 0);
  EXPECT_LT(rotation, 1000);
  EXPECT_GT(vertical, 0);
  EXPECT_LT(vertical, 5000);
  RecordProperty("samples_rotation", std::to_string(rotation));
  RecordProperty("samples_vertical", std::to_string(vertical));
}

TEST(PriorModels, AKnownRotationIsKeptAndHasNoCovariance) {
  const Scene scene = knownScene(Known::kRotation, {}, 3);
  const Selection found = PoseSelector().select(scene.matches);
  ASSERT_TRUE(found.pose) << found.message;
  EXPECT_EQ(found.pose->motion, Motion::kGeneral);
  EXPECT_EQ(found.pose->pose.rotation, scene.truth.rotation);
  EXPECT_EQ(cv::norm(found.pose->covariance.get_minor<3, 5>(0, 0)), 0);
  EXPECT_EQ(cv::norm(found.pose->covariance.get_minor<5, 3>(0, 0)), 0);
  EXPECT_GT(found.pose->covariance(3, 3), 0);
  EXPECT_GT(found.pose->covariance(4, 4), 0);
}

TEST(PriorModels, AKnownVerticalIsKeptAndTheAngleAboutItHasACovariance) {
  const Scene scene = knownScene(Known::kVertical, {}, 4);
  const Selection found = PoseSelector().select(scene.matches);
  ASSERT_TRUE(found.pose) << found.message;
  const cv::Vec3d left = scene.matches.prior->left_down, right = scene.matches.prior->right_down;
  EXPECT_LT(cv::norm(found.pose->pose.rotation * left - right), 1e-12);
  cv::Vec3d b1, b2;
  translationBasis(right, b1, b2);
  const auto variance = [&](const cv::Vec3d& axis) {
    const Vec5 direction(axis[0], axis[1], axis[2], 0, 0);
    return direction.dot(found.pose->covariance * direction);
  };
  EXPECT_GT(variance(right), 1e-10);
  EXPECT_LT(std::abs(variance(b1)), 1e-12 * variance(right));
  EXPECT_LT(std::abs(variance(b2)), 1e-12 * variance(right));
}

TEST(PriorModels, CovariancesOfFreeDirectionsAreTrue) {
  const double rotation = meanNormalisedError<2>(Known::kRotation);
  EXPECT_GT(rotation, 1.4);
  EXPECT_LT(rotation, 2.8);
  const double vertical = meanNormalisedError<3>(Known::kVertical);
  EXPECT_GT(vertical, 2.2);
  EXPECT_LT(vertical, 4.0);
  RecordProperty("rotation", std::to_string(rotation));
  RecordProperty("vertical", std::to_string(vertical));
}

TEST(PriorModels, APlaneHasOnePose) {
  for (const Known known : {Known::kRotation, Known::kVertical}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      SceneOptions options;
      options.scenario = Scenario::kPlane;
      options.right_share = 0.7;
      const Scene scene = knownScene(known, options, seed);
      const Selection found = PoseSelector().select(scene.matches);
      ASSERT_TRUE(found.pose) << found.message;
      EXPECT_EQ(found.pose->motion, Motion::kPlanar);
      EXPECT_FALSE(found.pose->second);
      EXPECT_LT(angleBetween(found.pose->pose.translation, scene.truth.translation), 0.06);
    }
  }
}

TEST(PriorModels, ACameraThatOnlyTurnsKeepsToThePrior) {
  SceneOptions options;
  options.scenario = Scenario::kRotation;
  options.right_share = 0.7;
  Scene scene = knownScene(Known::kRotation, options, 5);
  Selection found = PoseSelector().select(scene.matches);
  ASSERT_TRUE(found.pose) << found.message;
  EXPECT_EQ(found.pose->motion, Motion::kRotation);
  EXPECT_EQ(found.pose->pose.rotation, scene.truth.rotation);
  EXPECT_EQ(cv::norm(found.pose->covariance.get_minor<3, 3>(0, 0)), 0);
  Correspondences without = scene.matches;
  without.prior.reset();
  const Selection free = PoseSelector().select(without);
  ASSERT_TRUE(free.pose);
  EXPECT_NEAR(found.pose->noise, free.pose->noise, 0.01);

  scene = knownScene(Known::kVertical, options, 5);
  found = PoseSelector().select(scene.matches);
  ASSERT_TRUE(found.pose) << found.message;
  EXPECT_EQ(found.pose->motion, Motion::kRotation);
  const cv::Vec3d right = scene.matches.prior->right_down;
  EXPECT_LT(cv::norm(found.pose->pose.rotation * scene.matches.prior->left_down - right), 1e-12);
  const double error = vectorOf(scene.truth.rotation * found.pose->pose.rotation.t()).dot(right);
  const cv::Vec3d variance = found.pose->covariance.get_minor<3, 3>(0, 0) * right;
  EXPECT_LT(error * error, 16 * right.dot(variance));
  EXPECT_LT(cv::norm(variance - right * right.dot(variance)), 1e-12 * cv::norm(variance));
}

TEST(PriorModels, FewerMatchesAgreeWithAWrongRotation) {
  SceneOptions options;
  Scene scene = knownScene(Known::kRotation, options, 6);
  const double c = std::cos(0.2), s = std::sin(0.2);
  scene.matches.prior->rotation = cv::Matx33d(c, 0, s, 0, 1, 0, -s, 0, c) * scene.truth.rotation;
  const Selection wrong = PoseSelector().select(scene.matches);
  scene.matches.prior.reset();
  EXPECT_LT(2 * wrong.n_selected, PoseSelector().select(scene.matches).n_selected);
}

TEST(PriorModels, ARigJudgesEveryMatch) {
  SceneOptions options;
  options.right_share = 0.3;
  const Scene scene = knownScene(Known::kRig, options, 7);
  const Selection found = PoseSelector().select(scene.matches);
  ASSERT_EQ(found.status, Status::kOk) << found.message;
  ASSERT_TRUE(found.pose);
  EXPECT_EQ(found.iterations, 0);
  EXPECT_EQ(found.pose->motion, Motion::kGeneral);
  EXPECT_EQ(found.pose->pose.rotation, scene.truth.rotation);
  EXPECT_LT(cv::norm(found.pose->pose.translation - scene.truth.translation), 1e-15);
  EXPECT_EQ(cv::norm(found.pose->covariance), 0);
  EXPECT_NEAR(found.pose->noise, kNoise, 0.1);
  RayMatches rays;
  std::vector<std::uint8_t> exists;
  unproject(scene.matches, rays, exists);
  const cv::Matx33d essential = essentialOf(scene.truth);
  double squares = 0, inliers = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool agrees =
        std::abs(tangentSampson(essential, rays, i)) <= 1 && isInFront(scene.truth, rays, i, 1);
    EXPECT_EQ(found.mask[i] != 0, agrees) << i;
    if (scene.inlier[i] == 0) continue;
    squares += 2 * squaredRotationError(scene.truth.rotation, rays, i);
    ++inliers;
  }
  const double parallax = std::sqrt(squares / inliers);
  EXPECT_NEAR(found.pose->parallax, parallax, 0.1 * parallax);
}

TEST(PriorModels, ARigWithoutMatchesThatAgreeIsNoEvidence) {
  SceneOptions options;
  options.right_share = 0;
  const Scene scene = knownScene(Known::kRig, options, 8);
  EXPECT_EQ(PoseSelector().select(scene.matches).status, Status::kUncertain);
}

TEST(PriorModels, FewMatches) {
  SceneOptions options;
  options.right_share = 1;
  for (const Known known : {Known::kRotation, Known::kVertical, Known::kRig}) {
    for (std::size_t size = 0; size < 8; ++size) {
      options.size = size;
      const Scene scene = knownScene(known, options, 9);
      const Selection found = PoseSelector().select(scene.matches);
      EXPECT_NE(found.status, Status::kOk) << size;  // too few for any evidence
      EXPECT_EQ(found.mask.size(), size);
    }
  }
}

TEST(PriorModels, TheAnswerDoesNotDependOnEarlierCalls) {
  const Scene rotation = knownScene(Known::kRotation, {}, 10),
              vertical = knownScene(Known::kVertical, {}, 11);
  const PoseSelector selector;
  const Selection first = selector.select(rotation.matches);
  selector.select(vertical.matches);
  Correspondences without = rotation.matches;
  without.prior.reset();
  const Selection free = selector.select(without);
  const Selection again = selector.select(rotation.matches);
  EXPECT_EQ(first.mask, again.mask);
  ASSERT_TRUE(first.pose && again.pose && free.pose);
  EXPECT_EQ(first.pose->pose.translation, again.pose->pose.translation);
  EXPECT_NE(free.pose->pose.rotation, rotation.truth.rotation);
}

}  // namespace
}  // namespace corrsel::core
