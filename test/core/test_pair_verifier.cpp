#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "calibrated_scene.h"
#include "cameras.h"
#include "corrsel/database/pair_verifier.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using calibrated_scene::generate;
using calibrated_scene::Scenario;
using pose_scene::angleBetween;
using testing::errorOf;
using testing::mentions;

/// The point, moved into the image that noise has led out of.
cv::Point2f inside(float x, float y, const cv::Size& size) {
  return {std::clamp(x, 0.0F, static_cast<float>(size.width - 1)),
          std::clamp(y, 0.0F, static_cast<float>(size.height - 1))};
}

/// A generated pair as a store gives it. Keypoint i of both images belongs to match i.
struct StoredScene {
  calibrated_scene::Scene scene;
  StoredImage first, second;
  PairInput input;

  explicit StoredScene(const calibrated_scene::SceneOptions& options, std::uint64_t seed = 1,
                       bool calibrated = true)
      : scene(generate(options, seed)) {
    first = {3, "a.jpg", options.camera.size, options.camera, calibrated};
    second = {7, "b.jpg", options.camera.size, options.camera, calibrated};
    auto left = std::make_shared<StoredKeypoints>(), right = std::make_shared<StoredKeypoints>();
    for (std::uint32_t i = 0; i < scene.matches.size(); ++i) {
      left->positions.push_back(inside(scene.matches.left_x[i], scene.matches.left_y[i], first.size));
      right->positions.push_back(inside(scene.matches.right_x[i], scene.matches.right_y[i], second.size));
      input.matches.rows.push_back({i, i});
    }
    input.pair = {3, 7};
    input.first_keypoints = left;
    input.second_keypoints = right;
  }

  VerifiedPair verify(const PairVerifierOptions& options = {}) {
    input.first = &first;
    input.second = &second;
    Workspace workspace;
    return PairVerifier(options).verify(input, workspace);
  }

  /// Shares of the right matches that were kept, and of the kept ones that are right.
  std::pair<double, double> recallAndPrecision(const VerifiedPair& pair) const {
    double right = 0, all = 0;
    for (const KeypointPair& row : pair.geometry.inliers) right += scene.inlier[row[0]] != 0 ? 1 : 0;
    for (const std::uint8_t inlier : scene.inlier) all += inlier != 0 ? 1 : 0;
    return {right / all, right / static_cast<double>(pair.geometry.inliers.size())};
  }
};

calibrated_scene::SceneOptions optionsOf(Scenario scenario) {
  calibrated_scene::SceneOptions options;
  options.scenario = scenario;
  options.camera = testing::plainCamera();
  options.noise = 0.5;
  return options;
}

TEST(PairVerifier, CalibratedPairsHaveAPoseAndMatricesThatAgree) {
  StoredScene stored(optionsOf(Scenario::kGeneral));
  const VerifiedPair pair = stored.verify();
  EXPECT_EQ(pair.status, Status::kOk);
  EXPECT_GT(pair.confidence, 4);
  const TwoViewGeometry& geometry = pair.geometry;
  ASSERT_EQ(geometry.config, TwoViewConfig::kCalibrated) << pair.message;
  const auto [recall, precision] = stored.recallAndPrecision(pair);
  EXPECT_GT(recall, 0.9);
  EXPECT_GT(precision, 0.9);
  ASSERT_TRUE(geometry.pose && geometry.essential && geometry.fundamental);
  EXPECT_LT(cv::norm(geometry.pose->rotation - stored.scene.truth.rotation), 0.02);
  EXPECT_GT(geometry.pose->translation.dot(stored.scene.truth.translation), 0.998);
  const cv::Matx33d k = stored.first.camera->matrix;
  cv::Matx33d e = k.t() * *geometry.fundamental * k;
  e = e * (1 / cv::norm(e));
  const cv::Matx33d expected = *geometry.essential * (1 / cv::norm(*geometry.essential));
  EXPECT_LT(std::min(cv::norm(e - expected), cv::norm(e + expected)), 1e-9);
}

TEST(PairVerifier, WithoutCalibrationThereIsAFundamentalMatrixOnly) {
  StoredScene stored(optionsOf(Scenario::kGeneral), 1, false);
  const VerifiedPair pair = stored.verify();
  ASSERT_EQ(pair.geometry.config, TwoViewConfig::kUncalibrated) << pair.message;
  EXPECT_TRUE(pair.geometry.fundamental);
  EXPECT_FALSE(pair.geometry.essential || pair.geometry.pose || pair.geometry.homography);
  EXPECT_GT(stored.recallAndPrecision(pair).first, 0.85);
}

TEST(PairVerifier, TurnsArePanoramic) {
  for (const bool calibrated : {true, false}) {
    StoredScene stored(optionsOf(Scenario::kRotation), 2, calibrated);
    const VerifiedPair pair = stored.verify();
    ASSERT_EQ(pair.geometry.config,
              calibrated ? TwoViewConfig::kPanoramic : TwoViewConfig::kPlanarOrPanoramic)
        << pair.message;
    EXPECT_TRUE(pair.geometry.homography);
    EXPECT_FALSE(pair.geometry.fundamental || pair.geometry.essential);
    ASSERT_EQ(pair.geometry.pose.has_value(), calibrated);
    if (calibrated) {
      EXPECT_EQ(pair.geometry.pose->translation, cv::Vec3d());
    }
    EXPECT_GT(stored.recallAndPrecision(pair).first, 0.9);
  }
}

TEST(PairVerifier, PlanesHaveAHomography) {
  for (const bool calibrated : {true, false}) {
    StoredScene stored(optionsOf(Scenario::kPlane), 3, calibrated);
    const VerifiedPair pair = stored.verify();
    ASSERT_EQ(pair.geometry.config, calibrated ? TwoViewConfig::kPlanar : TwoViewConfig::kPlanarOrPanoramic)
        << pair.message;
    ASSERT_TRUE(pair.geometry.homography);
    EXPECT_GT(stored.recallAndPrecision(pair).first, 0.9);
  }
}

TEST(PairVerifier, UnrelatedImagesAreRejectedWithAReason) {
  calibrated_scene::SceneOptions options = optionsOf(Scenario::kGeneral);
  options.right_share = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const VerifiedPair pair = StoredScene(options, seed).verify();
    EXPECT_EQ(pair.geometry.config, TwoViewConfig::kUndefined);
    EXPECT_TRUE(pair.geometry.inliers.empty());
    EXPECT_FALSE(pair.message.empty());
    EXPECT_FALSE(pair.faulty);
  }
}

TEST(PairVerifier, AWrongFocalLengthGivesAnUncalibratedPair) {
  calibrated_scene::SceneOptions options = optionsOf(Scenario::kGeneral);
  options.right_share = 0.9;
  StoredScene stored(options, 4);
  for (StoredImage* image : {&stored.first, &stored.second}) {
    image->camera->matrix(0, 0) /= 5;
    image->camera->matrix(1, 1) /= 5;
  }
  const VerifiedPair pair = stored.verify();
  ASSERT_EQ(pair.geometry.config, TwoViewConfig::kUncalibrated) << pair.message;
  EXPECT_FALSE(pair.geometry.pose || pair.geometry.essential);
  EXPECT_GT(stored.recallAndPrecision(pair).first, 0.9);
}

TEST(PairVerifier, CamerasWithDistortionHaveNoMatricesOfPixels) {
  calibrated_scene::SceneOptions options = optionsOf(Scenario::kGeneral);
  options.camera = testing::fisheyeCamera();
  const VerifiedPair pair = StoredScene(options).verify();
  ASSERT_EQ(pair.geometry.config, TwoViewConfig::kCalibrated) << pair.message;
  EXPECT_TRUE(pair.geometry.essential && pair.geometry.pose);
  EXPECT_FALSE(pair.geometry.fundamental || pair.geometry.homography);
}

TEST(PairVerifier, EveryKeypointIsKeptOnce) {
  StoredScene stored(optionsOf(Scenario::kGeneral));
  const std::vector<KeypointPair> rows = stored.input.matches.rows;
  for (std::uint32_t i = 0; i + 1 < rows.size(); ++i) {
    stored.input.matches.rows.push_back({i, i + 1});
    stored.input.matches.rows.push_back(rows[i]);
  }
  const VerifiedPair pair = stored.verify();
  ASSERT_GT(pair.geometry.inliers.size(), 100U);
  std::set<std::uint32_t> left, right;
  for (const KeypointPair& row : pair.geometry.inliers) {
    EXPECT_TRUE(left.insert(row[0]).second);
    EXPECT_TRUE(right.insert(row[1]).second);
  }
}

TEST(PairVerifier, SelectorsWithoutAModelGetOne) {
  PairVerifierOptions options;
  options.selector = "lpm";
  calibrated_scene::SceneOptions scene = optionsOf(Scenario::kPlane);
  scene.right_share = 0.8;
  const VerifiedPair pair = StoredScene(scene).verify(options);
  EXPECT_EQ(pair.geometry.config, TwoViewConfig::kPlanar) << pair.message;
  EXPECT_TRUE(pair.geometry.homography);
}

TEST(PairVerifier, FewInliersAreRejected) {
  PairVerifierOptions options;
  options.min_matches = 200;
  const VerifiedPair pair = StoredScene(optionsOf(Scenario::kGeneral)).verify(options);
  EXPECT_EQ(pair.geometry.config, TwoViewConfig::kUndefined);
  EXPECT_TRUE(mentions(pair.message, {"200 are needed"}));
}

TEST(PairVerifier, FaultsNameTheRowAndTheRemedy) {
  StoredScene beyond(optionsOf(Scenario::kGeneral));
  beyond.input.matches.rows[5][1] = 4711;
  VerifiedPair pair = beyond.verify();
  EXPECT_TRUE(pair.faulty);
  EXPECT_TRUE(mentions(pair.message, {"match 5", "4711", "b.jpg", "300", "match the pair again"}));

  StoredScene outside(optionsOf(Scenario::kGeneral));
  outside.first.size = {320, 240};
  pair = outside.verify();
  EXPECT_TRUE(pair.faulty);
  EXPECT_TRUE(mentions(pair.message, {"a.jpg", "outside", "320x240", "scaled"}));

  StoredScene itself(optionsOf(Scenario::kGeneral));
  itself.input.pair = {3, 3};
  pair = itself.verify();
  EXPECT_TRUE(pair.faulty);
  EXPECT_TRUE(mentions(pair.message, {"itself"}));
}

TEST(PairVerifier, NoMatchesAndNaNAreNoFaults) {
  StoredScene empty(optionsOf(Scenario::kGeneral));
  empty.input.matches.rows.clear();
  VerifiedPair pair = empty.verify();
  EXPECT_FALSE(pair.faulty);
  EXPECT_EQ(pair.status, Status::kTooFew);

  StoredScene stored(optionsOf(Scenario::kGeneral));
  auto positions = std::make_shared<StoredKeypoints>(*stored.input.first_keypoints);
  positions->positions[0].x = std::nanf("");
  stored.input.first_keypoints = positions;
  pair = stored.verify();
  EXPECT_EQ(pair.geometry.config, TwoViewConfig::kCalibrated);
  for (const KeypointPair& row : pair.geometry.inliers) EXPECT_NE(row[0], 0U);
}

TEST(PairVerifier, TheProbabilitiesOfTheMatcherReachTheSelector) {
  StoredScene stored(optionsOf(Scenario::kGeneral));
  stored.input.matches.probability.assign(stored.input.matches.rows.size(), 0.5F);
  EXPECT_EQ(stored.verify().geometry.config, TwoViewConfig::kCalibrated);
  stored.input.matches.probability.front() = 2;
  const VerifiedPair pair = stored.verify();
  EXPECT_EQ(pair.status, Status::kUnsupportedInput);
  EXPECT_TRUE(mentions(pair.message, {"probability", "2"}));
}

TEST(PairVerifier, WrongOptionsAreNamed) {
  PairVerifierOptions options;
  options.selector = "nosuch";
  EXPECT_TRUE(mentions(errorOf([&] { PairVerifier{options}; }), {"nosuch", "auto"}));
  options = {};
  options.epipolar_threshold = -1;
  EXPECT_TRUE(mentions(errorOf([&] { PairVerifier{options}; }), {"epipolar_threshold", "-1"}));
}

TEST(PairVerifier, TheConfigurationNamesEveryOption) {
  PairVerifierOptions options;
  const std::string before = PairVerifier(options).configuration();
  EXPECT_TRUE(mentions(before, {"selector=auto:fast", "epipolar_threshold=3", "min_matches=15",
                                "min_confidence=7", "seed=0"}));
  options.seed = 1;
  EXPECT_NE(before, PairVerifier(options).configuration());
}

}  // namespace
}  // namespace corrsel::core
