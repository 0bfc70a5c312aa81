#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/datasets/scene.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/motion_labels.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::sharedData;

constexpr MatchSceneKind kStaticKinds[] = {
    MatchSceneKind::kPlane,   MatchSceneKind::kSpace,     MatchSceneKind::kRest, MatchSceneKind::kRotation,
    MatchSceneKind::kForward, MatchSceneKind::kTwoPlanes, MatchSceneKind::kWall, MatchSceneKind::kFacade};

/// Matches by what they are, and those of them that are labelled moving.
struct Tally {
  double object = 0, object_moving = 0, scene = 0, scene_moving = 0;

  void add(const MatchScene& truth, const Selection& selection) {
    std::vector<std::uint8_t> moving(truth.matches.size(), 0);
    for (const std::uint32_t row : movingRows(selection)) moving[row] = 1;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      object += truth.structure[i] == 2 ? 1 : 0;
      object_moving += truth.structure[i] == 2 && moving[i] != 0 ? 1 : 0;
      scene += truth.structure[i] == 1 ? 1 : 0;
      scene_moving += truth.structure[i] == 1 && moving[i] != 0 ? 1 : 0;
    }
  }
};

Selection labelled(const Correspondences& matches, const std::string& selector) {
  Selection selection = createSelector(selector)->select(matches);
  labelMotion(matches, selection);
  return selection;
}

SceneSpec sceneOf(MatchSceneKind kind, std::uint64_t seed = 0) {
  SceneSpec spec;
  spec.kind = kind;
  spec.inlier_ratio = 0.6;
  spec.seed = seed;
  return spec;
}

/// The groups, the mask and the counts of a labelled selection fit each other.
void expectConsistent(const Selection& selection) {
  ASSERT_EQ(selection.group.size(), selection.mask.size());
  std::size_t selected = 0;
  for (std::size_t i = 0; i < selection.mask.size(); ++i) {
    selected += selection.mask[i];
    ASSERT_LT(selection.group[i], static_cast<std::int32_t>(selection.motion.size()));
    EXPECT_TRUE(selection.group[i] < 0 || selection.mask[i] == 1);
  }
  EXPECT_EQ(selection.n_selected, selected);
}

class LabelsOf : public ::testing::TestWithParam<const char*> {};

TEST_P(LabelsOf, ObjectsOfSixToThirtyPercentMoveAndTheSceneStands) {
  for (const MatchSceneKind kind : {MatchSceneKind::kMovingObject, MatchSceneKind::kPassingObject}) {
    for (const double share : {0.06, 0.1, 0.2, 0.3}) {
      for (const double noise : {0.5, 1.0}) {
        Tally tally;
        for (const double inlier_ratio : {0.5, 0.7, 0.9}) {
          for (std::uint64_t seed = 100; seed < 105; ++seed) {
            SceneSpec spec = sceneOf(kind, seed);
            spec.object_share = share;
            spec.noise = noise;
            spec.inlier_ratio = inlier_ratio;
            MatchScene scene = makeScene(spec);
            if (std::string(GetParam()) == "pose")
              scene.matches.left_camera = scene.matches.right_camera = sceneCamera();
            const Selection selection = labelled(scene.matches, GetParam());
            expectConsistent(selection);
            tally.add(scene, selection);
          }
        }
        const std::string where = std::to_string(static_cast<int>(kind)) + ", share " +
                                  std::to_string(share) + ", noise " + std::to_string(noise);
        EXPECT_GE(tally.object_moving, 0.95 * tally.object) << where;
        EXPECT_LE(tally.scene_moving, 0.01 * tally.scene) << where;
      }
    }
  }
}

TEST_P(LabelsOf, NothingMovesInStaticScenes) {
  for (const MatchSceneKind kind : kStaticKinds) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      MatchScene scene = makeScene(sceneOf(kind, seed));
      if (std::string(GetParam()) == "pose")
        scene.matches.left_camera = scene.matches.right_camera = sceneCamera();
      const Selection selection = labelled(scene.matches, GetParam());
      EXPECT_EQ(movingRows(selection).size(), 0u) << static_cast<int>(kind) << ", seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MotionLabels, LabelsOf, ::testing::Values("auto", "pose", "usac:f"));

/// Replaces the object of a scene by one that moves without turning.
void moveObject(MatchScene& scene, const cv::Point2f& by) {
  Random random(1);
  for (std::size_t i = 0; i < scene.structure.size(); ++i) {
    if (scene.structure[i] != 2) continue;
    const double x = random.normal(), y = random.normal();
    scene.matches.right_x[i] = scene.matches.left_x[i] + by.x + static_cast<float>(0.5 * x);
    scene.matches.right_y[i] = scene.matches.left_y[i] + by.y + static_cast<float>(0.5 * y);
  }
}

TEST(MotionLabels, AtRestAnObjectMovesInEveryDirection) {
  for (int degrees = 0; degrees < 360; degrees += 45) {
    MatchScene scene = makeScene(sceneOf(MatchSceneKind::kPassingObject));
    const double angle = degrees * CV_PI / 180;
    moveObject(scene, {static_cast<float>(30 * std::cos(angle)), static_cast<float>(30 * std::sin(angle))});
    Tally tally;
    tally.add(scene, labelled(scene.matches, "auto"));
    EXPECT_GE(tally.object_moving, 0.95 * tally.object) << degrees;
    EXPECT_LE(tally.scene_moving, 0.01 * tally.scene) << degrees;
  }
}

TEST(MotionLabels, AnObjectThatMovesAlongTheEpipolarLinesLooksLikeOneAtAnotherDepth) {
  MatchScene scene = makeScene(sceneOf(MatchSceneKind::kMovingObject));
  const auto share = [&scene](const cv::Point2f& by) {
    moveObject(scene, by);
    Tally tally;
    tally.add(scene, labelled(scene.matches, "auto"));
    return tally.object_moving / tally.object;
  };
  EXPECT_LT(share({-150, 10}), 0.05);  // the camera moves to the right
  EXPECT_GT(share({-150, 60}), 0.95);
}

TEST(MotionLabels, WithCamerasAnObjectBehindTheCameraMoves) {
  MatchScene scene = makeScene(sceneOf(MatchSceneKind::kMovingObject));
  moveObject(scene, {120, 0});
  scene.matches.left_camera = scene.matches.right_camera = sceneCamera();
  Tally tally;
  tally.add(scene, labelled(scene.matches, "pose"));
  EXPECT_GE(tally.object_moving, 0.95 * tally.object);
  EXPECT_LE(tally.scene_moving, 0.01 * tally.scene);
}

TEST(MotionLabels, BeforeAPlaneParallaxAndMotionAreNotToldApart) {
  MatchScene scene = makeScene(sceneOf(MatchSceneKind::kPassingObject));
  moveObject(scene, {30, 20});
  for (std::size_t i = 0; i < scene.structure.size(); ++i)  // a camera that has turned
    scene.matches.right_x[i] += scene.structure[i] != 0 ? 40 : 0;
  const Selection selection = labelled(scene.matches, "auto");
  EXPECT_EQ(movingRows(selection).size(), 0u);
}

TEST(MotionLabels, NothingIsStatedWithoutAModelOfTheCamera) {
  const MatchScene scene = makeScene(sceneOf(MatchSceneKind::kMovingObject));
  for (const char* const selector : {"gms", "usac:h"}) {
    const Selection before = createSelector(selector)->select(scene.matches);
    const Selection after = labelled(scene.matches, selector);
    EXPECT_EQ(after.mask, before.mask);
    EXPECT_EQ(after.motion, std::vector<GroupMotion>(1, GroupMotion::kUnknown));
  }
}

TEST(MotionLabels, TheOrderOfTheMatchesDoesNotMatterAndInvalidOnesAreLeftOut) {
  const MatchScene scene = makeScene(sceneOf(MatchSceneKind::kMovingObject));
  const Selection selection = createSelector("auto")->select(scene.matches);
  Selection first = selection;
  labelMotion(scene.matches, first);
  ASSERT_GT(movingRows(first).size(), 50u);
  std::vector<std::uint32_t> reversed(scene.matches.size());
  std::iota(reversed.rbegin(), reversed.rend(), 0U);
  Correspondences turned = scene.matches.subset(reversed);
  turned.left_x.push_back(std::numeric_limits<float>::quiet_NaN());
  for (auto* column :
       {&turned.left_y, &turned.right_x, &turned.right_y, &turned.distance, &turned.second_distance})
    column->push_back(1);
  turned.left_frame.emplace_back();
  turned.right_frame.emplace_back();
  Selection second = selection;
  std::reverse(second.group.begin(), second.group.end());
  if (!second.group.empty()) second.group.push_back(-1);
  std::reverse(second.mask.begin(), second.mask.end());
  second.mask.push_back(0);
  labelMotion(turned, second);
  std::vector<std::uint32_t> rows = movingRows(second);
  for (std::uint32_t& row : rows) row = static_cast<std::uint32_t>(scene.matches.size()) - 1 - row;
  std::reverse(rows.begin(), rows.end());
  EXPECT_EQ(rows, movingRows(first));
  Selection again = first;
  labelMotion(scene.matches, again);  // a second call changes nothing
  EXPECT_EQ(again.mask, first.mask);
  EXPECT_EQ(again.motion, first.motion);
}

TEST(MotionLabels, InputsThatDoNotFitAreLeftAlone) {
  const MatchScene scene = makeScene(sceneOf(MatchSceneKind::kMovingObject));
  Selection selection = createSelector("auto")->select(scene.matches);
  labelMotion(scene.matches.subset({0, 1, 2}), selection);
  EXPECT_TRUE(selection.motion.empty());
  Selection nothing = createSelector("auto")->select({});
  labelMotion({}, nothing);
  EXPECT_TRUE(nothing.motion.empty());
  EXPECT_TRUE(movingRows(nothing).empty());
}

/// Photographs of scenes in which nothing moves.
TEST(MotionLabels, NothingMovesOnRealPairs) {
  int pairs = 0;
  const auto features = createExtractor("orb+orb");
  for (const char* const name : {"vgg", "strecha_dev"}) {
    const std::string folder = sharedData(name);
    if (folder.empty()) continue;
    const auto reader = openDataset(name, folder);
    for (std::size_t i = 0; i < reader->size(); i += 5, ++pairs) {
      const ImagePair pair = reader->read(i);
      const Correspondences matches =
          matchFeatures(features->extract(pair.left), features->extract(pair.right));
      const Selection selection = labelled(matches, "auto");
      EXPECT_LE(movingRows(selection).size(), 0.01 * selection.n_selected) << pair.id.text();
    }
  }
  if (pairs == 0) GTEST_SKIP() << "skipped: the datasets vgg and strecha_dev are not here";
}

}  // namespace
}  // namespace corrsel::core
