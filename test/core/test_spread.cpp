#include <gtest/gtest.h>

#include <set>

#include "features/parts/spread.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

std::vector<cv::Point2f> randomPoints(int n, const cv::Rect2f& area, std::uint64_t seed) {
  Random random(seed);
  std::vector<cv::Point2f> points;
  for (int i = 0; i < n; ++i) {
    const auto y = float(random.uniform(area.y, area.y + area.height));
    const auto x = float(random.uniform(area.x, area.x + area.width));
    points.emplace_back(x, y);
  }
  return points;
}

TEST(Spread, KeepsAsManyAsAskedForInOrder) {
  const auto points = randomPoints(1000, {0, 0, 640, 480}, 1);
  for (const std::size_t most : {1, 2, 10, 999, 1000, 5000}) {
    const auto kept = spreadOverImage(points, {640, 480}, most);
    EXPECT_EQ(kept.size(), std::min<std::size_t>(most, 1000));
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    EXPECT_EQ(std::set<std::size_t>(kept.begin(), kept.end()).size(), kept.size());
  }
  EXPECT_EQ(spreadOverImage(points, {640, 480}, 1), std::vector<std::size_t>{0});
  EXPECT_TRUE(spreadOverImage({}, {640, 480}, 10).empty());
}

TEST(Spread, WeakPartsOfTheImageKeepTheirStrongest) {
  // The 900 strongest points are in one corner, 100 weak ones everywhere.
  auto points = randomPoints(900, {0, 0, 100, 100}, 1);
  const auto others = randomPoints(100, {0, 0, 640, 480}, 2);
  points.insert(points.end(), others.begin(), others.end());
  const auto kept = spreadOverImage(points, {640, 480}, 200);
  const auto weak = std::count_if(kept.begin(), kept.end(), [](std::size_t rank) { return rank >= 900; });
  EXPECT_GE(weak, 90);
  EXPECT_EQ(kept.front(), 0u);
}

TEST(Spread, PointsOutsideTheImageAreOfItsBorder) {
  EXPECT_EQ(spreadOverImage({{-5, -5}, {1000, 1000}, {3, 1e6F}}, {640, 480}, 3).size(), 3u);
}

}  // namespace
}  // namespace corrsel::core
