#include <gtest/gtest.h>

#include <iostream>

#include "base/checksum.h"
#include "corrsel/datasets/scene.h"
#include "geometry/homography.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::quality;

/// The scenes agree with their description, which reports quote.
TEST(Scene, HaveTheirInliersAndNoise) {
  for (const MatchSceneKind kind : {MatchSceneKind::kPlane, MatchSceneKind::kSpace}) {
    const auto scene = makeScene({kind, 2000, 0.3, 5});
    EXPECT_EQ(scene.matches.inconsistency(), "");
    EXPECT_EQ(std::accumulate(scene.inlier.begin(), scene.inlier.end(), 0), 600);
    double ratio[2] = {0, 0};
    for (std::size_t i = 0; i < 2000; ++i) {
      ratio[scene.inlier[i]] += scene.matches.distance[i] / scene.matches.second_distance[i];
    }
    EXPECT_NEAR(ratio[1] / 600, 0.60, 0.02);
    EXPECT_NEAR(ratio[0] / 1400, 0.78, 0.02);
    const bool is_plane = kind == MatchSceneKind::kPlane;
    const Selection found =
        createSelector(is_plane ? "ransac:h" : "ransac:f", {{"threshold", "3"}, {"max_iterations", "20000"}})
            ->select(scene.matches);
    EXPECT_GT(quality(found.mask, scene.inlier).recall, is_plane ? 97 : 95);
    if (!is_plane) continue;
    const auto within = [&scene, &found](double tolerance) {
      std::size_t met = 0;
      for (std::size_t i = 0; i < 2000; ++i) {
        const cv::Point2f l = scene.left[i], r = scene.right[i];
        met += scene.inlier[i] && homographyError(found.model, l.x, l.y, r.x, r.y) <= tolerance * tolerance;
      }
      return static_cast<double>(met) / 600;
    };
    EXPECT_NEAR(within(3), 0.989, 0.01);
    EXPECT_NEAR(within(1), 0.393, 0.06);
  }
}

TEST(Scene, SortedPutsTheBestRatioFirst) {
  SceneSpec spec{MatchSceneKind::kPlane, 500, 0.3, 5};
  const auto any = makeScene(spec);
  spec.sorted = true;
  const auto sorted = makeScene(spec);
  EXPECT_EQ(std::accumulate(sorted.inlier.begin(), sorted.inlier.end(), 0), 150);
  EXPECT_NE(any.matches.left_x, sorted.matches.left_x);
  for (std::size_t i = 1; i < 500; ++i) {
    EXPECT_LE(sorted.matches.distance[i - 1] / sorted.matches.second_distance[i - 1],
              sorted.matches.distance[i] / sorted.matches.second_distance[i]);
  }
  EXPECT_EQ(sorted.left[3].x, sorted.matches.left_x[3]);
}

constexpr MatchSceneKind kAllKinds[] = {MatchSceneKind::kPlane,         MatchSceneKind::kSpace,
                                        MatchSceneKind::kRest,          MatchSceneKind::kRotation,
                                        MatchSceneKind::kForward,       MatchSceneKind::kMovingObject,
                                        MatchSceneKind::kPassingObject, MatchSceneKind::kTwoPlanes,
                                        MatchSceneKind::kWall,          MatchSceneKind::kFacade};

/// Share of the correct matches of one structure that a model explains, given the selector that finds it.
double explained(const MatchScene& scene, const std::string& selector, int structure) {
  const Selection found =
      createSelector(selector, {{"threshold", "4"}, {"max_iterations", "20000"}})->select(scene.matches);
  double total = 0, selected = 0;
  for (std::size_t i = 0; i < scene.structure.size(); ++i) {
    total += scene.structure[i] == structure;
    selected += scene.structure[i] == structure && found.mask[i];
  }
  return selected / total;
}

TEST(Scene, KindsHaveTheModelsThatTheyAreNamedFor) {
  const struct {
    MatchSceneKind kind;
    bool homography, fundamental;  // whether this model is determined
  } cases[] = {{MatchSceneKind::kRest, true, false},      {MatchSceneKind::kRotation, true, false},
               {MatchSceneKind::kForward, false, true},   {MatchSceneKind::kMovingObject, false, true},
               {MatchSceneKind::kTwoPlanes, false, true}, {MatchSceneKind::kWall, false, true},
               {MatchSceneKind::kFacade, true, false}};
  for (const auto& c : cases) {
    SCOPED_TRACE(static_cast<int>(c.kind));
    const MatchScene scene = makeScene({c.kind, 2000, 0.5, 5});
    const double by_homography = explained(scene, "ransac:h", 1);
    if (c.homography) {
      EXPECT_GT(by_homography, 0.97);
    } else {
      EXPECT_LT(by_homography, 0.85);
    }
    if (c.fundamental) {
      EXPECT_GT(explained(scene, "ransac:f", 1), 0.95);
    }
  }
}

TEST(Scene, ObjectMovesByItselfAndHasItsSize) {
  for (const MatchSceneKind kind : {MatchSceneKind::kMovingObject, MatchSceneKind::kPassingObject}) {
    for (const double share : {0.06, 0.3}) {
      SceneSpec spec{kind, 4000, 0.5, 2};
      spec.object_share = share;
      const MatchScene scene = makeScene(spec);
      // The background that it hides in the right image increases its share of the correct matches.
      const double members = double(std::count(scene.structure.begin(), scene.structure.end(), 2)) / 2000;
      EXPECT_GT(members, share - 0.01);
      EXPECT_LT(members, 1.25 * share + 0.01);
      EXPECT_LT(explained(scene, kind == MatchSceneKind::kMovingObject ? "ransac:f" : "ransac:h", 2), 0.4);
    }
  }
}

TEST(Scene, ObjectHidesTheBackground) {
  SceneSpec spec{MatchSceneKind::kPassingObject, 4000, 0.5, 2};
  spec.noise = 0;
  const MatchScene scene = makeScene(spec);
  // The hull of the object is convex: the centre of gravity of its points lies in it, in both images.
  cv::Point2f centre[2] = {{0, 0}, {0, 0}};
  float members = 0;
  for (std::size_t i = 0; i < scene.structure.size(); ++i) {
    if (scene.structure[i] != 2) continue;
    centre[0] += scene.left[i];
    centre[1] += scene.right[i];
    members += 1;
  }
  for (std::size_t i = 0; i < scene.structure.size(); ++i) {
    if (scene.structure[i] != 1) continue;
    EXPECT_GT(cv::norm(scene.left[i] - centre[0] / members), 100);
    EXPECT_GT(cv::norm(scene.right[i] - centre[1] / members), 100);
  }
}

TEST(Scene, RestWithoutNoiseIsTheSameImage) {
  SceneSpec spec{MatchSceneKind::kRest, 300, 0.5, 4};
  spec.noise = 0;
  const MatchScene scene = makeScene(spec);
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_EQ(scene.left[i] == scene.right[i], scene.inlier[i] != 0);
    if (!scene.inlier[i]) continue;
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_FLOAT_EQ(scene.matches.left_frame[i][k], scene.matches.right_frame[i][k]);
    }
  }
}

/// gtm needs nothing but the frames, which must therefore fit the motion.
TEST(Scene, FramesOfCorrectMatchesFollowTheMotion) {
  for (const MatchSceneKind kind : kAllKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    const MatchScene scene = makeScene({kind, 1000, 0.9, 3});
    double sum = 0;
    for (std::size_t i = 0; i < 1000; ++i) {
      if (scene.structure[i] != 1) continue;
      const AffineFrame &l = scene.matches.left_frame[i], &r = scene.matches.right_frame[i];
      // A turn shows in the angle of the first axis. No motion of the background turns by more than 15
      // degrees.
      const double turn = std::atan2(r[3], r[0]) - std::atan2(l[3], l[0]);
      sum += std::cos(turn);
    }
    EXPECT_GT(sum / double(std::count(scene.structure.begin(), scene.structure.end(), 1)), 0.9);
  }
}

TEST(Scene, ColumnsLeftOutDoNotChangeTheOthers) {
  for (const MatchSceneKind kind : kAllKinds) {
    SceneSpec spec{kind, 200, 0.5, 7};
    const MatchScene full = makeScene(spec);
    spec.frames = spec.distances = spec.sizes = false;
    const MatchScene bare = makeScene(spec);
    EXPECT_EQ(bare.matches.right_x, full.matches.right_x);
    EXPECT_EQ(bare.structure, full.structure);
    EXPECT_TRUE(bare.matches.left_frame.empty() && bare.matches.right_frame.empty());
    EXPECT_TRUE(bare.matches.distance.empty() && bare.matches.second_distance.empty());
    EXPECT_EQ(bare.matches.left_size, cv::Size());
    EXPECT_EQ(bare.matches.right_size, cv::Size());
    EXPECT_EQ(full.matches.left_frame.size(), 200u);
  }
}

/// The same values come from all compilers and processors, see docs/evaluation.md.
TEST(Scene, IsTheSameOnAllMachines) {
  const char* const expected[] = {
      "f8565898c491c10d", "43e7429e07e2401d", "537985269122423d", "f180c2ecd968d461", "d2fe9a17ef369a85",
      "9c5cbbf261c2cf01", "4231a1072d356c51", "1d6e0fc6415bbaf9", "93c4052426d00529", "816bb1ca8034e7e9"};
  for (std::size_t kind = 0; kind < std::size(kAllKinds); ++kind) {
    SceneSpec spec{kAllKinds[kind], 500, 0.5, 11};
    Checksum checksum;
    for (const bool sorted : {false, true}) {
      spec.sorted = sorted;
      const MatchScene scene = makeScene(spec);
      const auto add = [&checksum](const auto& column) {
        checksum.add(column.data(), column.size() * sizeof(column[0]));
      };
      const Correspondences& m = scene.matches;
      for (const auto* column :
           {&m.left_x, &m.left_y, &m.right_x, &m.right_y, &m.distance, &m.second_distance})
        add(*column);
      add(m.left_frame);
      add(m.right_frame);
      add(scene.inlier);
      add(scene.structure);
    }
    std::cout << checksum.text() << " scene of kind " << kind << "\n";
    EXPECT_EQ(checksum.text(), expected[kind]) << kind;
  }
}

/// Windows taken for their neighbours agree with each other, but not with the correct matches.
TEST(Scene, FacadeHasRepeatedWindows) {
  const MatchScene scene = makeScene({MatchSceneKind::kFacade, 2000, 0.2, 1});
  const cv::Matx33d model =
      createSelector("ransac:h", {{"max_iterations", "20000"}})->select(scene.matches).model;
  std::size_t aligned = 0;
  for (std::size_t i = 0; i < 2000; ++i) {
    if (scene.inlier[i]) continue;
    for (const int step : {-3, -2, -1, 1, 2, 3}) {
      const cv::Point2f l = scene.left[i], r = scene.right[i];
      aligned += homographyError(model, l.x + float(80 * step), l.y, r.x, r.y) < 25;
    }
  }
  EXPECT_NEAR(double(aligned) / 1600, 0.5, 0.06);
}

}  // namespace
}  // namespace corrsel::core
