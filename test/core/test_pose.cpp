#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "calibrated_scene.h"
#include "cameras.h"
#include "corrsel/selectors/pose.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using calibrated_scene::generate;
using calibrated_scene::Scenario;
using calibrated_scene::Scene;
using calibrated_scene::SceneOptions;
using pose_scene::angleBetween;
using testing::allCameras;
using testing::LevelGuard;
using testing::mentions;
using testing::quality;

constexpr double kThresholdPerNoise = 2.5;

PoseOptions optionsFor(double noise) {
  PoseOptions options;
  options.threshold = kThresholdPerNoise * noise;
  return options;
}

Selection select(const Scene& scene, double noise = 1) {
  return PoseSelector(optionsFor(noise)).select(scene.matches);
}

SceneOptions sceneOptions(const Camera& camera = pose_scene::pinhole()) {
  SceneOptions options;
  options.camera = camera;
  return options;
}

Scene sceneOf(Scenario scenario, std::uint64_t seed, double right_share = 0.5) {
  SceneOptions options = sceneOptions();
  options.scenario = scenario;
  options.right_share = right_share;
  return generate(options, seed);
}

/// The matches that are right.
Correspondences inliersOf(const Scene& scene) { return scene.matches.subset(selectedRows(scene.inlier)); }

/// w of exp([w]_x) = R, for less than a right angle, rad.
cv::Vec3d rotationVector(const cv::Matx33d& r) {
  const cv::Vec3d sine = 0.5 * cv::Vec3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double length = cv::norm(sine);
  return length > 0 ? cv::Vec3d(sine * (std::asin(std::min(1.0, length)) / length)) : sine;
}

double rotationError(const Pose& pose, const Pose& truth) {
  return cv::norm(rotationVector(truth.rotation * pose.rotation.t()));
}

double translationError(const Pose& pose, const Pose& truth) {
  return angleBetween(pose.translation, truth.translation);
}

/// Whether all of the covariance is NaN.
bool isUnknown(const cv::Matx<double, 5, 5>& covariance) {
  return std::all_of(std::begin(covariance.val), std::end(covariance.val),
                     [](double value) { return std::isnan(value); });
}

bool isKnown(const cv::Matx<double, 5, 5>& covariance) {
  return std::all_of(std::begin(covariance.val), std::end(covariance.val),
                     [](double value) { return std::isfinite(value); });
}

/// Squared error of a pose in units of its covariance (NEES): 5 in the mean if the covariance is right.
double squaredErrorInUnits(const PoseResult& found, const Pose& truth) {
  const cv::Vec3d w = rotationVector(truth.rotation * found.pose.rotation.t());
  cv::Vec3d b1, b2;
  translationBasis(found.pose.translation, b1, b2);
  const double along = truth.translation.dot(found.pose.translation);
  const cv::Vec<double, 5> error(w[0], w[1], w[2], truth.translation.dot(b1) / along,
                                 truth.translation.dot(b2) / along);
  const cv::Matx<double, 5, 5> information = found.covariance.inv(cv::DECOMP_CHOLESKY);
  return error.dot(information * error);
}

void expectSame(const Selection& a, const Selection& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.iterations, b.iterations);
  ASSERT_TRUE(a.pose && b.pose);
  EXPECT_EQ(a.pose->motion, b.pose->motion);
  EXPECT_EQ(a.pose->pose.rotation, b.pose->pose.rotation);
  EXPECT_EQ(a.pose->pose.translation, b.pose->pose.translation);
  EXPECT_EQ(a.pose->covariance, b.pose->covariance);
  EXPECT_EQ(a.pose->noise, b.pose->noise);
  EXPECT_EQ(a.pose->parallax, b.pose->parallax);
  EXPECT_EQ(a.model, b.model);
}

TEST(Pose, NeedsBothCameras) {
  Correspondences matches;
  matches.add({1, 2}, {3, 4});
  const Selection selection = PoseSelector().select(matches);
  EXPECT_EQ(selection.status, Status::kUnsupportedInput);
  EXPECT_TRUE(mentions(selection.message, {"left camera"}));
}

TEST(Pose, FindsThePoseOfEveryCamera) {
  for (const auto& [name, camera] : allCameras()) {
    for (const double noise : {0.5, 2.0}) {
      SCOPED_TRACE(name + ", noise " + std::to_string(noise));
      SceneOptions options = sceneOptions(camera);
      options.noise = noise;
      const Scene scene = generate(options, 1);
      const Selection selection = select(scene, noise);
      EXPECT_EQ(selection.status, Status::kOk) << selection.message;
      ASSERT_TRUE(selection.pose);
      EXPECT_EQ(selection.pose->motion, Motion::kGeneral);
      EXPECT_LT(rotationError(selection.pose->pose, scene.truth), 6e-3 * noise);
      EXPECT_LT(translationError(selection.pose->pose, scene.truth), 2.5e-2 * noise);
      EXPECT_NEAR(selection.pose->noise, noise, 0.2 * noise);
      EXPECT_EQ(selection.sigma, selection.pose->noise);
      EXPECT_EQ(selection.model_kind, ModelKind::kEssential);
      EXPECT_EQ(selection.scene, SceneKind::kRigid);
      const testing::Quality q = quality(selection.mask, scene.inlier);
      EXPECT_GT(q.precision, 92);
      EXPECT_GT(q.recall, 95);
    }
  }
}

TEST(Pose, ScoresAreSquaredErrorsAndMatchesBehindAreNotSelected) {
  SceneOptions options = sceneOptions();
  options.size = 1000;
  options.right_share = 0.3;
  const Selection selection = select(generate(options, 2));
  const double limit = -kThresholdPerNoise * kThresholdPerNoise;
  std::size_t behind = 0;
  for (std::size_t i = 0; i < selection.mask.size(); ++i) {
    ASSERT_LE(selection.score[i], 0);
    if (selection.mask[i] != 0) {
      EXPECT_GE(selection.score[i], limit);
    } else if (selection.score[i] > limit) {
      ++behind;
    }
  }
  EXPECT_GT(behind, 0U);
}

TEST(Pose, AnswersAreTheSameForAnyOrderOfTheMatchesAndEveryLevel) {
  const LevelGuard guard;
  for (const bool has_distances : {false, true}) {
    SceneOptions options = sceneOptions(pose_scene::fisheye());
    options.has_distances = has_distances;
    options.right_share = 0.35;
    const Scene scene = generate(options, 3);
    const Selection first = select(scene), again = select(scene);
    ASSERT_TRUE(first.pose);
    expectSame(first, again);
    EXPECT_EQ(first.mask, again.mask);
    const std::vector<std::uint32_t> order = testing::permutation(scene.matches.size(), 4);
    const Selection permuted = PoseSelector(optionsFor(1)).select(scene.matches.subset(order));
    expectSame(first, permuted);
    EXPECT_EQ(permuted.mask, testing::reordered(first.mask, order));
    for (const KernelLevel level : supportedKernelLevels()) {
      SCOPED_TRACE(toString(level));
      setKernelLevel(level);
      const Selection other = select(scene);
      expectSame(first, other);
      EXPECT_EQ(first.mask, other.mask);
    }
  }
}

TEST(Pose, AnswersDoNotDependOnTheCallBefore) {
  const Scene scene = sceneOf(Scenario::kGeneral, 5, 0.3), other = sceneOf(Scenario::kGeneral, 6, 0.3);
  PoseOptions options = optionsFor(1);
  options.covariance = false;
  Workspace fresh, used;
  const Selection expected = PoseSelector(options).select(scene.matches, fresh);
  PoseSelector(optionsFor(1)).select(other.matches, used);
  const Selection found = PoseSelector(options).select(scene.matches, used);
  ASSERT_TRUE(expected.pose && found.pose);
  EXPECT_EQ(found.pose->noise, expected.pose->noise);
  EXPECT_EQ(found.pose->uncertain, expected.pose->uncertain);
  EXPECT_EQ(found.pose->pose.rotation, expected.pose->pose.rotation);
}

TEST(Pose, Rest) {
  const Scene scene = sceneOf(Scenario::kRest, 7);
  const Selection selection = select(scene);
  EXPECT_EQ(selection.status, Status::kOk);
  ASSERT_TRUE(selection.pose);
  EXPECT_EQ(selection.pose->motion, Motion::kRest);
  EXPECT_EQ(selection.pose->pose.rotation, cv::Matx33d::eye());
  EXPECT_EQ(selection.pose->pose.translation, cv::Vec3d());
  EXPECT_EQ(selection.model_kind, ModelKind::kRotation);
  EXPECT_EQ(selection.model, cv::Matx33d::eye());
  EXPECT_EQ(selection.scene, SceneKind::kAtRest);
  const testing::Quality q = quality(selection.mask, scene.inlier);
  EXPECT_GT(q.precision, 98);
  EXPECT_GT(q.recall, 95);
}

TEST(Pose, PureRotationHasNoTranslation) {
  for (const auto& [name, camera] : allCameras()) {
    SCOPED_TRACE(name);
    SceneOptions options = sceneOptions(camera);
    options.scenario = Scenario::kRotation;
    const Scene scene = generate(options, 8);
    const Selection selection = select(scene);
    ASSERT_TRUE(selection.pose);
    EXPECT_EQ(selection.pose->motion, Motion::kRotation);
    EXPECT_EQ(selection.pose->pose.translation, cv::Vec3d());
    EXPECT_LT(rotationError(selection.pose->pose, scene.truth), 1e-3);
    EXPECT_NEAR(selection.pose->noise, 1, 0.2);
    EXPECT_EQ(selection.model_kind, ModelKind::kRotation);
    EXPECT_EQ(selection.model, selection.pose->pose.rotation);
    EXPECT_EQ(selection.scene, SceneKind::kPlaneOrRotation);
    EXPECT_GT(quality(selection.mask, scene.inlier).recall, 95);
    for (int row = 0; row < 5; ++row) {
      for (int column = 0; column < 5; ++column) {
        EXPECT_EQ(std::isfinite(selection.pose->covariance(row, column)), row < 3 && column < 3);
      }
    }
  }
}

/// The mean of the squared error in units of the covariance is 3 for rotations.
TEST(Pose, TheCovarianceOfRotationsHolds) {
  double sum = 0;
  constexpr int kScenes = 60;
  for (int seed = 0; seed < kScenes; ++seed) {
    SceneOptions options = sceneOptions(pose_scene::cameras()[static_cast<std::size_t>(seed % 3)]);
    options.scenario = Scenario::kRotation;
    const Scene scene = generate(options, static_cast<std::uint64_t>(100 + seed));
    const Selection selection = select(scene);
    ASSERT_TRUE(selection.pose);
    ASSERT_EQ(selection.pose->motion, Motion::kRotation);
    const cv::Vec3d w = rotationVector(scene.truth.rotation * selection.pose->pose.rotation.t());
    sum += w.dot(selection.pose->covariance.get_minor<3, 3>(0, 0).inv(cv::DECOMP_CHOLESKY) * w);
  }
  EXPECT_GT(sum / kScenes, 2);
  EXPECT_LT(sum / kScenes, 4);
}

TEST(Pose, APlaneHasTwoPoses) {
  int second = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SceneOptions options = sceneOptions();
    options.scenario = Scenario::kPlane;
    options.baseline = 0.4;
    const Scene scene = generate(options, seed);
    const Selection selection = select(scene);
    ASSERT_TRUE(selection.pose);
    EXPECT_EQ(selection.pose->motion, Motion::kPlanar);
    EXPECT_EQ(selection.model_kind, ModelKind::kEssential);
    EXPECT_EQ(selection.scene, SceneKind::kPlaneOrRotation);
    double error = translationError(selection.pose->pose, scene.truth);
    if (selection.pose->second) {
      ++second;
      error = std::min(error, translationError(*selection.pose->second, scene.truth));
    }
    EXPECT_LT(error, 0.05);
  }
  EXPECT_GE(second, 3);
}

TEST(Pose, ForwardMotion) {
  const Scene scene = sceneOf(Scenario::kForward, 9);
  const Selection selection = select(scene);
  ASSERT_TRUE(selection.pose);
  EXPECT_EQ(selection.pose->motion, Motion::kGeneral);
  EXPECT_LT(translationError(selection.pose->pose, scene.truth), 0.02);
  EXPECT_LT(rotationError(selection.pose->pose, scene.truth), 4e-3);
}

TEST(Pose, TooFewPoints) {
  const Correspondences inliers = inliersOf(sceneOf(Scenario::kGeneral, 10));
  const Selection four = PoseSelector().select(inliers.subset({0, 1, 2, 3}));
  EXPECT_EQ(four.status, Status::kTooFew);
  EXPECT_TRUE(mentions(four.message, {"4", "5"}));
  EXPECT_FALSE(four.pose);
  EXPECT_EQ(four.n_selected, 0U);
  const Selection repeated = PoseSelector().select(inliers.subset({0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3}));
  EXPECT_EQ(repeated.status, Status::kTooFew);
}

TEST(Pose, AllPointsOfOneImageEqual) {
  Scene scene = sceneOf(Scenario::kGeneral, 11);
  for (const bool left : {true, false}) {
    Correspondences matches = scene.matches;
    (left ? matches.left_x : matches.right_x).assign(matches.size(), 100);
    (left ? matches.left_y : matches.right_y).assign(matches.size(), 200);
    const Selection selection = PoseSelector().select(matches);
    EXPECT_EQ(selection.status, Status::kDegenerate) << selection.message;
    EXPECT_FALSE(selection.pose);
    EXPECT_EQ(selection.n_selected, 0U);
  }
}

TEST(Pose, FewerThanEightAgree) {
  for (const std::size_t size : {5, 6, 7}) {
    std::vector<std::uint32_t> rows(size);
    std::iota(rows.begin(), rows.end(), 0U);
    const Selection selection =
        PoseSelector(optionsFor(1)).select(inliersOf(sceneOf(Scenario::kGeneral, 12)).subset(rows));
    EXPECT_EQ(selection.status, Status::kNoModel) << size << selection.message;
    EXPECT_FALSE(selection.pose);
    EXPECT_EQ(selection.n_selected, 0U);
  }
}

TEST(Pose, RepeatedPointsCountOnce) {
  const Correspondences inliers = inliersOf(sceneOf(Scenario::kGeneral, 13));
  std::vector<std::uint32_t> rows;
  for (int times = 0; times < 20; ++times)
    for (std::uint32_t i = 0; i < 7; ++i) rows.push_back(i);
  EXPECT_EQ(PoseSelector(optionsFor(1)).select(inliers.subset(rows)).status, Status::kNoModel);

  // The covariance of matches that are given twice is that of the matches.
  std::vector<std::uint32_t> once(inliers.size());
  std::iota(once.begin(), once.end(), 0U);
  std::vector<std::uint32_t> twice = once;
  twice.insert(twice.end(), once.begin(), once.end());
  const Selection expected = PoseSelector(optionsFor(1)).select(inliers);
  const Selection found = PoseSelector(optionsFor(1)).select(inliers.subset(twice));
  ASSERT_TRUE(expected.pose && found.pose);
  EXPECT_LT(cv::norm(found.pose->covariance - expected.pose->covariance),
            0.01 * cv::norm(expected.pose->covariance));
  EXPECT_EQ(found.n_selected, 2 * expected.n_selected);
}

TEST(Pose, AllOnOneLineThroughTheImage) {
  Correspondences matches;
  matches.left_camera = matches.right_camera = pose_scene::pinhole();
  Random random(14);
  const Pose truth = pose_scene::examplePose();
  while (matches.size() < 100) {
    const double x = random.uniform(-2, 2);
    const double z = random.uniform(4, 12);
    const cv::Vec3d point(x, 0.3 * x, z);  // in a plane with the left camera
    cv::Point2d left, right;
    project(*matches.left_camera, point, left);
    project(*matches.right_camera, truth.rotation * point + truth.translation, right);
    const cv::Point2d noisy_left = pose_scene::noisy(left, 0.3, random);
    const cv::Point2d noisy_right = pose_scene::noisy(right, 0.3, random);
    matches.add(cv::Point2f(noisy_left), cv::Point2f(noisy_right));
  }
  Correspondences reversed = matches;
  std::swap(reversed.left_x, reversed.right_x);
  std::swap(reversed.left_y, reversed.right_y);
  for (const Correspondences& one : {matches, reversed}) {
    const Selection selection = PoseSelector().select(one);
    EXPECT_EQ(selection.status, Status::kDegenerate) << selection.message;
    EXPECT_TRUE(mentions(selection.message, {"line"}));
    EXPECT_FALSE(selection.pose);
    EXPECT_EQ(selection.n_selected, 0U);
  }
}

TEST(Pose, CountsMatchesWithoutARayAsIgnored) {
  SceneOptions options = sceneOptions(testing::radtanCamera());
  const Scene scene = generate(options, 15);
  Correspondences matches = scene.matches;
  matches.left_x[3] = -900;  // beyond the turning point of the distortion
  matches.left_y[3] = 250;
  matches.right_x[7] = -900;
  matches.right_y[7] = 250;
  matches.right_y[11] = std::numeric_limits<float>::quiet_NaN();
  matches.left_x[13] = std::numeric_limits<float>::infinity();
  const Selection selection = PoseSelector(optionsFor(1)).select(matches);
  ASSERT_TRUE(selection.pose);
  EXPECT_EQ(selection.n_ignored, 4U);
  for (const std::size_t i : {3, 7, 11, 13}) EXPECT_EQ(selection.mask[i], 0) << i;
  EXPECT_LT(rotationError(selection.pose->pose, scene.truth), 4e-3);

  matches.left_x.assign(matches.size(), -900);
  matches.left_y.assign(matches.size(), 250);
  const Selection none = PoseSelector(optionsFor(1)).select(matches);
  EXPECT_EQ(none.status, Status::kTooFew) << none.message;
  EXPECT_EQ(none.n_ignored, matches.size());
}

TEST(Pose, WrongMatchesOnly) {
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Selection selection = select(sceneOf(Scenario::kGeneral, 20 + seed, 0));
    EXPECT_TRUE(selection.status == Status::kNoModel || selection.status == Status::kUncertain)
        << toString(selection.status);
    refused += selection.status == Status::kNoModel;
    EXPECT_EQ(selection.pose.has_value(), selection.status == Status::kUncertain);
  }
  EXPECT_GE(refused, 3);
}

TEST(Pose, StopsAtTheTimeLimit) {
  const Scene scene = sceneOf(Scenario::kGeneral, 25, 0.5);
  PoseOptions options = optionsFor(1);
  options.confidence = 1;  // never stops otherwise
  options.max_seconds = 5;
  const testing::TickingClock clock(1);
  const Selection selection = PoseSelector(options).select(scene.matches);
  EXPECT_EQ(selection.status, Status::kTimeLimit);
  EXPECT_TRUE(mentions(selection.message, {"max_seconds = 5"}));
  EXPECT_LT(selection.iterations, 20000);
  ASSERT_TRUE(selection.pose);
  EXPECT_LT(rotationError(selection.pose->pose, scene.truth), 4e-3);
}

TEST(Pose, WithoutCovariance) {
  PoseOptions options = optionsFor(1);
  options.covariance = false;
  for (const Scenario scenario : {Scenario::kGeneral, Scenario::kRotation, Scenario::kRest}) {
    const Scene scene = sceneOf(scenario, 26);
    const Selection selection = PoseSelector(options).select(scene.matches);
    ASSERT_TRUE(selection.pose);
    EXPECT_TRUE(isUnknown(selection.pose->covariance));
    EXPECT_FALSE(selection.pose->uncertain);
    EXPECT_NEAR(selection.pose->noise, 1, 0.2);
    EXPECT_LT(rotationError(selection.pose->pose, scene.truth), 4e-3);
  }
}

TEST(Pose, TheAdaptiveThresholdFollowsTheNoise) {
  double fixed = 0, adaptive = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SceneOptions scene_options = sceneOptions();
    scene_options.noise = 1;
    const Scene scene = generate(scene_options, 30 + seed);
    PoseOptions options;
    options.threshold = 1;  // 2.5 times the noise would be better
    const Selection narrow = PoseSelector(options).select(scene.matches);
    options.adaptive = true;
    const Selection wide = PoseSelector(options).select(scene.matches);
    ASSERT_TRUE(narrow.pose && wide.pose);
    fixed += translationError(narrow.pose->pose, scene.truth);
    adaptive += translationError(wide.pose->pose, scene.truth);
    EXPECT_NEAR(wide.pose->noise, 1, 0.25);
  }
  EXPECT_LT(adaptive, 0.9 * fixed);
}

TEST(Pose, CovarianceIsGivenWhereItHoldsOnly) {
  int uncertain = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SceneOptions options = sceneOptions();
    options.size = 400;
    options.right_share = 0.15;
    options.noise = 2;
    options.baseline = 0.5;  // neighbours do not move alike, so that there is no local support
    const Selection selection = select(generate(options, 50 + seed), 2);
    if (!selection.pose || selection.pose->motion != Motion::kGeneral) continue;
    uncertain += selection.pose->uncertain;
    EXPECT_EQ(isUnknown(selection.pose->covariance), selection.pose->uncertain);
    EXPECT_EQ(isKnown(selection.pose->covariance), !selection.pose->uncertain);
  }
  EXPECT_GT(uncertain, 0);
  EXPECT_LT(uncertain, 10);
}

TEST(Pose, HasConfidenceAndProbability) {
  const Scene scene = sceneOf(Scenario::kGeneral, 60);
  Selection selection = select(scene);
  EXPECT_GT(selection.confidence, 10);
  const double confidence = selection.confidence;
  addConfidence(scene.matches, selection);
  EXPECT_EQ(selection.confidence, confidence);
  addProbability(scene.matches, selection);
  ASSERT_EQ(selection.probability.size(), scene.matches.size());
  double right = 0, wrong = 0, inliers = 0;
  for (std::size_t i = 0; i < selection.probability.size(); ++i) {
    (scene.inlier[i] != 0 ? right : wrong) += static_cast<double>(selection.probability[i]);
    inliers += scene.inlier[i] != 0 ? 1 : 0;
  }
  EXPECT_GT(right / inliers, 0.85);
  EXPECT_LT(wrong / (300 - inliers), 0.15);

  const Scene turned = sceneOf(Scenario::kRotation, 61);
  Selection rotation = select(turned);
  EXPECT_GT(rotation.confidence, 10);
  addProbability(turned.matches, rotation);
  ASSERT_EQ(rotation.probability.size(), turned.matches.size());
  EXPECT_GT(rotation.probability[static_cast<std::size_t>(
                std::find(turned.inlier.begin(), turned.inlier.end(), 1) - turned.inlier.begin())],
            0.5F);
}

/// Squared errors in units of the covariance of all scenes of a share of inliers.
std::vector<double> squaredErrors(double right_share, int scenes, std::uint64_t first_seed, int& uncertain) {
  std::vector<double> errors;
  uncertain = 0;
  for (int k = 0; k < scenes; ++k) {
    const double noise = std::exp2(k / 3 % 3 - 1);
    SceneOptions options = sceneOptions(pose_scene::cameras()[static_cast<std::size_t>(k % 3)]);
    options.size = 400;
    options.right_share = right_share;
    options.noise = noise;
    options.baseline = 0.15;
    const Scene scene = generate(options, first_seed + static_cast<std::uint64_t>(k));
    const Selection selection = select(scene, noise);
    EXPECT_TRUE(selection.pose && selection.pose->motion == Motion::kGeneral) << k;
    if (!selection.pose || selection.pose->motion != Motion::kGeneral) continue;
    if (selection.pose->uncertain) {
      ++uncertain;
    } else {
      errors.push_back(squaredErrorInUnits(*selection.pose, scene.truth));
    }
  }
  return errors;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Share of the poses whose truth is in the ellipsoid of 95 % of the normal distribution.
double coverage(const std::vector<double>& errors) {
  constexpr double kQuantile = 11.0705;  // of chi^2 with 5 degrees of freedom
  const auto inside = std::count_if(errors.begin(), errors.end(), [](double e) { return e <= kQuantile; });
  return static_cast<double>(inside) / static_cast<double>(errors.size());
}

/// 3000 scenes have a mean of 5.2 to 5.3 and a coverage of 93.7 to 93.9 %. The limits are those of the
/// requirement, 4.6 to 5.4 and 93.5 to 96.5 %, and the coverage has a standard error of 1 %.
TEST(Pose, TheCovarianceHolds) {
  constexpr int kScenes = 300;
  for (const double right_share : {0.95, 0.7}) {
    int uncertain;
    const std::vector<double> errors = squaredErrors(right_share, kScenes, 1000, uncertain);
    SCOPED_TRACE(std::to_string(right_share) + ": " + std::to_string(mean(errors)) + ", " +
                 std::to_string(coverage(errors)));
    EXPECT_EQ(uncertain, 0);
    EXPECT_GT(mean(errors), 4.6);
    EXPECT_LT(mean(errors), 5.4);
    EXPECT_GT(coverage(errors), 0.925);
    EXPECT_LT(coverage(errors), 0.975);
  }
}

TEST(Pose, TheCovarianceHoldsWithFewInliers) {
  constexpr int kScenes = testing::kSanitized ? 90 : 180;
  int uncertain;
  const std::vector<double> errors = squaredErrors(0.3, kScenes, 5000, uncertain);
  SCOPED_TRACE(std::to_string(mean(errors)) + ", " + std::to_string(coverage(errors)));
  EXPECT_LT(uncertain, kScenes / 2);
  EXPECT_GT(mean(errors), 4.5);
  EXPECT_LT(mean(errors), 6);
}

}  // namespace
}  // namespace corrsel::core
