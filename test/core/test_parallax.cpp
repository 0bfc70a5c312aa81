#include <gtest/gtest.h>

#include <array>

#include "auto/parallax.h"
#include "geometry/fundamental.h"
#include "geometry/residual.h"
#include "search/ordering.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

struct Found {
  bool parallax;
  cv::Matx33d fundamental;
};

/// The plane on which matches move by 60 px to the left.
const cv::Matx33d kPlane(1, 0, -60, 0, 1, 0, 0, 0, 1);

/// 100 matches on the plane, `off` ones at random depths, which have the best descriptors, and `wrong` ones.
/// @param disparities  of the matches off the plane, px
Correspondences scene(int off, int wrong, const std::array<double, 2>& disparities = {80, 300}) {
  Random random(1);
  Correspondences m;
  const auto add = [&](double disparity) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    m.add(left, left - cv::Point2d(disparity, 0) + 0.3 * normalPoint(random));
  };
  for (int i = 0; i < off; ++i) add(random.uniform(disparities[0], disparities[1]));
  for (int i = 0; i < 100; ++i) add(60);
  for (int i = 0; i < wrong; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    m.add(left, uniformPoint(random, kSceneWidth, kSceneHeight));
  }
  return m;
}

/// Runs the test on matches that are sorted by their quality.
/// @param ranked  whether the test is told that they are
Found test(const Correspondences& sorted, const cv::Matx33d& homography, bool ranked = true) {
  std::vector<std::uint32_t> rows;
  Ordering().shuffle(sorted, 0, rows);
  const Correspondences m = sorted.subset(rows);
  std::vector<std::uint32_t> best_first(rows.size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) best_first[rows[i]] = i;
  const NormalizedMatches normalized = normalizeMatches(m);
  std::vector<double> errors(m.size());
  pixelErrors(Residual::kSmallerTransfer, homography, m, errors.data());
  const cv::Matx33d plane = normalized.homographyFromPixels(homography);
  Found found{};
  found.parallax = ParallaxTest().find({m, normalized, best_first, ranked, plane, errors, 5},
                                       double{kSceneWidth} * kSceneHeight, 1.5, 0, found.fundamental);
  return found;
}

TEST(ParallaxTest, FindsTheEpipolarGeometryOfPointsOffThePlane) {
  const Found found = test(scene(150, 100), kPlane);
  ASSERT_TRUE(found.parallax);
  EXPECT_LT(sampsonError(found.fundamental, 300, 200, 100, 200), 1);
  EXPECT_GT(sampsonError(found.fundamental, 300, 200, 300, 230), 100);
}

TEST(ParallaxTest, FindsTheEpipolarGeometryOfPointsNearThePlane) {
  const Found found = test(scene(25, 400, {66, 80}), kPlane);
  ASSERT_TRUE(found.parallax);
  EXPECT_LT(sampsonError(found.fundamental, 300, 200, 230, 200), 1);
}

TEST(ParallaxTest, FindsNoneAmongOutliers) {
  EXPECT_FALSE(test(scene(0, 500), kPlane).parallax);
  EXPECT_FALSE(test(scene(0, 500), kPlane, false).parallax);
}

TEST(ParallaxTest, DescriptorsMayConfuseAFewPointsOffThePlane) {
  const Correspondences few = scene(25, 400);
  EXPECT_FALSE(test(few, kPlane, true).parallax);
  // Without descriptors, there is nothing that could have confused repeated structure.
  EXPECT_TRUE(test(few, kPlane, false).parallax);
}

TEST(ParallaxTest, WindowsThatRepeatAreNoParallax) {
  Random random(1);
  Correspondences m;
  for (int i = 0; i < 300; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    // Of five matches, three are right, one is one to three windows off, and one is imprecise.
    cv::Point2d off;
    if (i % 5 == 3) off = {7.0 * (1 + static_cast<int>(random.index(3))), 0};
    if (i % 5 == 4) off = 8 * normalPoint(random);
    m.add(left, left - cv::Point2d(60, 0) - off + 0.3 * normalPoint(random));
  }
  EXPECT_FALSE(test(m, kPlane).parallax);
}

TEST(ParallaxTest, NeedsTwoMatchesOffThePlane) {
  EXPECT_FALSE(test(scene(1, 0), kPlane).parallax);
  EXPECT_FALSE(test(scene(0, 0), kPlane, false).parallax);
}

TEST(ParallaxTest, FindsDepthAmongManyOutliers) {
  // 200 of 1300 matches agree; 8 times what chance gives, and more than there are on the plane.
  EXPECT_TRUE(test(scene(200, 1000), kPlane).parallax);
}

}  // namespace
}  // namespace corrsel::core
