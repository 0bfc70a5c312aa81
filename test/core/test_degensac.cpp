#include <gtest/gtest.h>

#include "corrsel/selectors/usac.h"
#include "geometry/fundamental.h"
#include "geometry/homography.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/homography_model.h"
#include "search/local_optimization.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Stereo matches of which the first `on_plane` lie on one plane in space.
Scene planeAndMore(std::size_t on_plane, std::size_t off_plane, double noise, std::uint64_t seed) {
  Scene scene = stereoScene({off_plane, 1.0, noise, seed});
  // The homography of the plane z = 8 for the cameras of stereoScene().
  const cv::Matx33d camera(700, 0, 400, 0, 700, 300, 0, 0, 1);
  const cv::Matx33d rotation(std::cos(0.1), 0, std::sin(0.1), 0, 1, 0, -std::sin(0.1), 0, std::cos(0.1));
  const cv::Matx33d shift(0, 0, -1.0 / 8, 0, 0, 0.15 / 8, 0, 0, 0.2 / 8);
  const cv::Matx33d h = camera * (rotation + shift) * camera.inv();
  Random random(seed + 77);
  Correspondences matches;
  while (matches.size() < on_plane) {
    const cv::Point2d left = uniformPoint(random, 799, 599);
    const cv::Point2d right = projected(h, left.x, left.y) + noise * normalPoint(random);
    matches.add(cv::Point2f(left), cv::Point2f(right));
  }
  for (std::size_t i = 0; i < off_plane; ++i) {
    const Correspondences& m = scene.matches;
    matches.add({m.left_x[i], m.left_y[i]}, {m.right_x[i], m.right_y[i]});
  }
  scene.matches = matches;
  scene.inlier.assign(matches.size(), 1);
  return scene;
}

TEST(Degensac, SceneIsWhatItClaims) {
  const Scene scene = planeAndMore(50, 20, 0.0, 1);
  std::vector<double> errors(70);
  pixelErrors(Residual::kSampson, scene.model, scene.matches, errors.data());
  for (const double error : errors) EXPECT_LT(error, 1e-4);
}

/// Normalised matches in random order, and where each input row went.
struct Prepared {
  NormalizedMatches matches;
  std::vector<std::uint32_t> position;
};

Prepared prepared(const Correspondences& matches) {
  const std::vector<std::uint32_t> rows = permutation(matches.size(), 5);
  Prepared result;
  normalizeMatches(matches, rows, result.matches);
  result.position.resize(rows.size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) result.position[rows[i]] = i;
  return result;
}

TEST(Degensac, GetsOffADominantPlane) {
  int degenerate = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = planeAndMore(200, 60, 0.1, seed);
    const Prepared p = prepared(scene.matches);
    DegeneracyMemory memory;
    memory.random = Random(seed);
    const Verifier verifier(p.matches, Residual::kSampson, 1.5 * p.matches.scale, true);
    // Six matches on the plane and one off it.
    std::uint32_t sample[7];
    for (std::uint32_t k = 0; k < 6; ++k) sample[k] = p.position[k * 17 + 3];
    sample[6] = p.position[210];
    cv::Matx33d models[3];
    const int count = fundamentalFromSeven(p.matches, sample, models);
    for (int k = 0; k < count; ++k) {
      Candidate best;
      verifier.improve(models[k], best);
      const std::size_t before = best.inliers;
      const std::int64_t cost = best.cost;
      if (before < 195 || before > 240) continue;  // does not hold the plane, or is right by luck
      ++degenerate;
      EXPECT_TRUE(escapeDominantPlane(verifier, sample, memory, best));
      EXPECT_LT(best.cost, cost);
      EXPECT_GT(best.inliers, 240u) << "from " << before;
    }
  }
  EXPECT_GT(degenerate, 10);
}

TEST(Degensac, ParallaxGivesTheFundamentalMatrixOfAPlaneAndMore) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = planeAndMore(200, 60, 0.1, seed);
    const Prepared p = prepared(scene.matches);
    const Verifier verifier(p.matches, Residual::kSampson, 1.5 * p.matches.scale, true);
    const Verifier on_plane(p.matches, Residual::kTransfer, 3 * p.matches.scale, true);
    // The plane through four of its matches, refined; a sample of the matches off it.
    const std::uint32_t four[] = {p.position[3], p.position[60], p.position[120], p.position[190]};
    Candidate plane;
    cv::Matx33d h;
    ASSERT_TRUE(homographyFromFour(p.matches, four, h));
    on_plane.improve(h, plane);
    optimizeLocally(HomographyModel(Residual::kTransfer), on_plane, plane);
    const std::vector<std::uint32_t> off_plane(p.position.begin() + 200, p.position.begin() + 230);
    Candidate best;
    Random random(seed), same(seed);
    EXPECT_TRUE(improveByParallax(verifier, plane.model, off_plane, 300, random, best));
    EXPECT_GT(best.inliers, 240u);
    // It only ever improves, and is reproducible.
    Candidate again;
    improveByParallax(verifier, plane.model, off_plane, 300, same, again);
    EXPECT_EQ(again.model, best.model);
    again.cost = 0;
    EXPECT_FALSE(improveByParallax(verifier, plane.model, off_plane, 300, random, again));
    EXPECT_EQ(again.model, best.model);
  }
}

TEST(Degensac, LeavesASampleWithoutAPlaneAlone) {
  int left_alone = 0, tried = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = stereoScene({200, 1.0, 0.3, seed});
    const Prepared p = prepared(scene.matches);
    DegeneracyMemory memory;
    memory.random = Random(seed);
    const Verifier verifier(p.matches, Residual::kSampson, 1.5 * p.matches.scale, true);
    const std::uint32_t sample[7] = {3, 30, 60, 90, 120, 150, 180};
    cv::Matx33d models[3];
    const int count = fundamentalFromSeven(p.matches, sample, models);
    for (int k = 0; k < count; ++k) {
      Candidate best;
      verifier.improve(models[k], best);
      const std::int64_t cost = best.cost;
      ++tried;
      left_alone += !escapeDominantPlane(verifier, sample, memory, best);
      EXPECT_LE(best.cost, cost);
    }
  }
  EXPECT_GT(left_alone, tried * 8 / 10);
}

TEST(Degensac, UsacFindsTheEpipolarGeometryBehindADominantPlane) {
  // 5 % of the matches off the plane: seven-match samples nearly never hold the two that are needed.
  double with = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Scene scene = planeAndMore(570, 30, 0.3, seed);
    UsacOptions options;
    options.model = ModelKind::kFundamental;
    options.local_optimization = false;
    const auto offPlane = [](const Selection& s) {
      double selected = 0;
      for (std::size_t i = 570; i < 600; ++i) selected += s.mask[i];
      return selected / 30;
    };
    with += offPlane(UsacSelector(options).select(scene.matches));
    options.degensac = false;
    without += offPlane(UsacSelector(options).select(scene.matches));
  }
  EXPECT_GT(with / 10, 0.9);
  EXPECT_LT(without / 10, 0.5);
}

}  // namespace
}  // namespace corrsel::core
