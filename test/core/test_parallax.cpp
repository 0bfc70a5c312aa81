#include <gtest/gtest.h>

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
Correspondences scene(int off, int wrong) {
  Random random(1);
  Correspondences m;
  const auto add = [&](double disparity) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    m.add(left, left - cv::Point2d(disparity, 0) + 0.3 * normalPoint(random));
  };
  for (int i = 0; i < off; ++i) add(random.uniform(80, 300));
  for (int i = 0; i < 100; ++i) add(60);
  for (int i = 0; i < wrong; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    m.add(left, uniformPoint(random, kSceneWidth, kSceneHeight));
  }
  return m;
}

/// Runs the test on matches that are sorted by their quality.
Found test(const Correspondences& sorted, const cv::Matx33d& homography) {
  std::vector<std::uint32_t> rows;
  Ordering().shuffle(sorted, 0, rows);
  const Correspondences m = sorted.subset(rows);
  std::vector<std::uint32_t> best_first(rows.size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) best_first[rows[i]] = i;
  const NormalizedMatches normalized = normalizeMatches(m);
  std::vector<double> errors(m.size());
  pixelErrors(Residual::kSmallerTransfer, homography, m, errors.data());
  Found found{};
  found.parallax =
      ParallaxTest().find(m, normalized, best_first, normalized.homographyFromPixels(homography), errors,
                          double{kSceneWidth} * kSceneHeight, {5, 1.5}, 0, found.fundamental);
  return found;
}

TEST(ParallaxTest, FindsTheEpipolarGeometryOfPointsOffThePlane) {
  const Found found = test(scene(150, 100), kPlane);
  ASSERT_TRUE(found.parallax);
  EXPECT_LT(sampsonError(found.fundamental, 300, 200, 100, 200), 1);
  EXPECT_GT(sampsonError(found.fundamental, 300, 200, 300, 230), 100);
}

TEST(ParallaxTest, FindsNoneAmongOutliers) { EXPECT_FALSE(test(scene(0, 500), kPlane).parallax); }

TEST(ParallaxTest, AFewPointsOffThePlaneAreNotEnough) { EXPECT_FALSE(test(scene(20, 300), kPlane).parallax); }

TEST(ParallaxTest, NeedsTwoMatchesOffThePlane) { EXPECT_FALSE(test(scene(1, 0), kPlane).parallax); }

TEST(ParallaxTest, FindsDepthAmongManyOutliers) {
  // 200 of 1300 matches agree; 8 times what chance gives, and more than there are on the plane.
  EXPECT_TRUE(test(scene(200, 1000), kPlane).parallax);
}

}  // namespace
}  // namespace corrsel::core
