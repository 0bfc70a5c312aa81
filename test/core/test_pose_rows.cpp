#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "benchmark/pose_rows.h"
#include "corrsel/datasets/calibrated_scene.h"
#include "datasets/posed_truth.h"

namespace corrsel::core {
namespace {

struct Case {
  CalibratedScene scene;
  GroundTruth truth;
  Selection selection;  ///< of the right matches, without a pose
};

Case caseOf(const Camera& camera, SceneMotion motion) {
  CalibratedSceneSpec spec;
  spec.left_camera = spec.right_camera = camera;
  spec.motion = motion;
  spec.noise = 0.3;
  Case result;
  result.scene = makeCalibratedScene(spec);
  result.truth = truthOf(result.scene.pose, camera, camera);
  result.selection.mask = result.scene.inlier;
  return result;
}

PoseRow rowOf(const Case& given) {
  return measurePose(given.truth, {}, given.scene.matches, given.selection);
}

/// The true pose, which a selector would give.
PoseResult truePose(const Case& given) {
  PoseResult result;
  result.motion = Motion::kGeneral;
  result.pose.rotation = given.scene.pose.rotation;
  result.pose.translation = cv::normalize(given.scene.pose.translation);
  result.covariance = cv::Matx<double, 5, 5>::eye() * 1e-4;
  return result;
}

TEST(PoseRows, CommonEstimatorSeesEveryCamera) {
  for (const Camera& camera : {scenePinhole(), sceneRational(), sceneFisheye(), scenePanorama()}) {
    const PoseRow row = rowOf(caseOf(camera, SceneMotion::kGeneral));
    EXPECT_EQ(row.model, PoseModel::kEssential) << toString(camera.model);
    EXPECT_LT(row.pose_error, 1) << toString(camera.model);
    EXPECT_FALSE(row.own);
    if (camera.isPlainPinhole()) {
      EXPECT_EQ(row.epipolar_precision, 1);
    }
  }
}

TEST(PoseRows, OwnPoseIsComparedWithTheTruth) {
  Case given = caseOf(sceneFisheye(), SceneMotion::kGeneral);
  given.selection.pose = truePose(given);
  cv::Matx33d turn(std::cos(0.02), -std::sin(0.02), 0, std::sin(0.02), std::cos(0.02), 0, 0, 0, 1);
  given.selection.pose->pose.rotation = turn * given.selection.pose->pose.rotation;
  Pose second = given.selection.pose->pose;
  second.rotation = turn * turn * second.rotation;
  given.selection.pose->second = second;
  const PoseRow row = rowOf(given);
  ASSERT_TRUE(row.own);
  EXPECT_EQ(row.own->motion, Motion::kGeneral);
  EXPECT_EQ(row.own->true_motion, Motion::kGeneral);
  EXPECT_NEAR(row.own->rotation_error, 0.02 * 180 / CV_PI, 1e-9);
  EXPECT_NEAR(row.own->translation_error, 0, 1e-6);
  EXPECT_EQ(row.own->pose_error, row.own->rotation_error);
  EXPECT_NEAR(row.own->second_error, 0.06 * 180 / CV_PI, 1e-9);
  EXPECT_NEAR(row.own->normalized.squared, 0.02 * 0.02 / 1e-4, 1e-9);
  EXPECT_EQ(row.own->normalized.degrees, 5u);
  EXPECT_FALSE(row.own->uncertain);
}

TEST(PoseRows, VerdictsWithoutATranslation) {
  Case given = caseOf(scenePinhole(), SceneMotion::kGeneral);
  given.selection.pose.emplace();  // kNone
  PoseRow row = rowOf(given);
  ASSERT_TRUE(row.own);
  EXPECT_EQ(row.own->motion, Motion::kNone);
  EXPECT_EQ(row.own->pose_error, kFailedPose);
  EXPECT_TRUE(std::isnan(row.own->rotation_error));
  EXPECT_EQ(row.own->normalized.degrees, 0u);
  given.selection.pose->motion = Motion::kRotation;
  given.selection.pose->pose.rotation = given.scene.pose.rotation;
  row = rowOf(given);
  EXPECT_EQ(row.own->pose_error, kFailedPose) << "the camera has moved";
  EXPECT_NEAR(row.own->rotation_error, 0, 1e-9);
  Case turned = caseOf(scenePanorama(), SceneMotion::kRotation);
  turned.selection.pose = given.selection.pose;
  turned.selection.pose->pose.rotation = turned.scene.pose.rotation;
  turned.selection.pose->covariance = cv::Matx<double, 5, 5>::eye();
  row = rowOf(turned);
  EXPECT_EQ(row.own->true_motion, Motion::kRotation);
  EXPECT_NEAR(row.own->pose_error, 0, 1e-9);
  EXPECT_EQ(row.own->normalized.degrees, 3u);
}

TEST(PoseRows, NothingIsKnownOfFailedSelectionsAndPairsWithoutPose) {
  Case given = caseOf(scenePinhole(), SceneMotion::kGeneral);
  given.selection.pose = truePose(given);
  given.truth.pose.reset();
  EXPECT_FALSE(rowOf(given).own);
  given = caseOf(scenePinhole(), SceneMotion::kGeneral);
  given.selection.pose = truePose(given);
  given.selection.status = Status::kUnsupportedInput;
  EXPECT_FALSE(rowOf(given).own);
}

}  // namespace
}  // namespace corrsel::core
