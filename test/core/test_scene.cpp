#include <gtest/gtest.h>

#include "corrsel/datasets/scene.h"
#include "geometry/homography.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::quality;

/// The scenes agree with their description, which reports quote.
TEST(Scene, HaveTheirInliersAndNoise) {
  for (const SceneKind kind : {SceneKind::kPlane, SceneKind::kSpace}) {
    const auto scene = makeScene({kind, 2000, 0.3, 5});
    EXPECT_EQ(scene.matches.inconsistency(), "");
    EXPECT_EQ(std::accumulate(scene.inlier.begin(), scene.inlier.end(), 0), 600);
    double ratio[2] = {0, 0};
    for (std::size_t i = 0; i < 2000; ++i) {
      ratio[scene.inlier[i]] += scene.matches.distance[i] / scene.matches.second_distance[i];
    }
    EXPECT_NEAR(ratio[1] / 600, 0.60, 0.02);
    EXPECT_NEAR(ratio[0] / 1400, 0.78, 0.02);
    const bool is_plane = kind == SceneKind::kPlane;
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
  SceneSpec spec{SceneKind::kPlane, 500, 0.3, 5};
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

}  // namespace
}  // namespace corrsel::core
