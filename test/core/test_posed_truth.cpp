#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "corrsel/datasets/calibrated_scene.h"
#include "corrsel/evaluation/errors.h"
#include "datasets/posed_truth.h"

namespace corrsel::core {
namespace {

CalibratedScene sceneOf(const Camera& camera, SceneMotion motion) {
  CalibratedSceneSpec spec;
  spec.left_camera = spec.right_camera = camera;
  spec.motion = motion;
  spec.noise = 0;
  spec.n = 200;
  return makeCalibratedScene(spec);
}

TEST(PosedTruth, IsThatOfTheRaysUnlessBothCamerasArePinholes) {
  const struct {
    Camera left, right;
    TruthKind moved, turned;
  } cameras[] = {{scenePinhole(), scenePinhole(), TruthKind::kFundamental, TruthKind::kHomography},
                 {scenePinhole(), sceneRational(), TruthKind::kEssential, TruthKind::kRotation},
                 {sceneFisheye(), scenePinhole(), TruthKind::kEssential, TruthKind::kRotation},
                 {scenePanorama(), scenePanorama(), TruthKind::kEssential, TruthKind::kRotation}};
  for (const auto& [left, right, moved, turned] : cameras) {
    RelativePose pose;
    EXPECT_EQ(truthOf(pose, left, right).kind, turned);
    pose.translation = {0, 2, 0};
    const GroundTruth truth = truthOf(pose, left, right);
    EXPECT_EQ(truth.kind, moved);
    EXPECT_NEAR(cv::norm(truth.matrix), 1, 1e-12);
    ASSERT_TRUE(truth.pose);
    EXPECT_NO_THROW(truth.pose->check());
  }
}

TEST(PosedTruth, RightMatchesAgreeWithIt) {
  for (const Camera& camera : {scenePinhole(), sceneRational(), sceneFisheye(), scenePanorama()}) {
    for (const SceneMotion motion : {SceneMotion::kRest, SceneMotion::kRotation, SceneMotion::kGeneral,
                                     SceneMotion::kForward, SceneMotion::kPlane}) {
      const CalibratedScene scene = sceneOf(camera, motion);
      const GroundTruth truth = truthOf(scene.pose, camera, camera);
      const std::vector<double> errors = groundTruthErrors(truth, scene.matches);
      int wrong_by_far = 0;
      for (std::size_t i = 0; i < errors.size(); ++i) {
        const double limit = scene.inlier[i] != 0 ? 0.01 : std::numeric_limits<double>::infinity();
        EXPECT_LE(errors[i], limit) << toString(camera.model) << toString(motion);
        wrong_by_far += scene.inlier[i] == 0 && errors[i] > 10 ? 1 : 0;
      }
      EXPECT_GT(wrong_by_far, 40) << toString(camera.model) << toString(motion);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
