#include <gtest/gtest.h>

#include <set>

#include "points/place_index.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(PlaceIndex, FindsAPointThatIsNearerThanTheReach) {
  PlaceIndex places;
  EXPECT_FALSE(places.isTaken(0, 0));
  places.clear(3, 8);
  EXPECT_EQ(places.add(100, 50), 0u);
  EXPECT_EQ(places.add(-1e6F, 3), 1u);
  EXPECT_EQ(places.findWithin(107.9F, 50), 0u);
  EXPECT_EQ(places.findWithin(108, 50), PlaceIndex::kNone);
  EXPECT_EQ(places.findWithin(106, 56), PlaceIndex::kNone);
  EXPECT_EQ(places.findWithin(-1e6F, -4), 1u);
  places.clear(3, 8);
  EXPECT_FALSE(places.isTaken(100, 50));
}

TEST(PlaceIndex, AgreesWithAPlainSearch) {
  Random random(4);
  for (const float reach : {2.0F, 8.0F, 60.0F}) {
    PlaceIndex places;
    places.clear(100, reach);
    std::vector<cv::Point2f> points;
    for (int i = 0; i < 400; ++i) {
      const cv::Point2f p(float(random.uniform(-200, 200)), float(random.uniform(-200, 200)));
      const bool taken = std::any_of(points.begin(), points.end(), [&](const cv::Point2f& q) {
        return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) < reach * reach;
      });
      ASSERT_EQ(places.isTaken(p.x, p.y), taken);
      places.add(p.x, p.y);
      points.push_back(p);
    }
    for (int query = 0; query < 50; ++query) {
      const double x = random.uniform(-220, 220), y = random.uniform(-220, 220);
      const double w = random.uniform(0, 100), h = random.uniform(0, 100);
      std::set<std::uint32_t> visited;
      EXPECT_FALSE(places.visitNear(x, y, w, h, [&](std::uint32_t number) {
        visited.insert(number);
        return false;
      }));
      for (std::uint32_t i = 0; i < points.size(); ++i) {
        if (std::abs(points[i].x - x) <= w && std::abs(points[i].y - y) <= h) {
          ASSERT_EQ(visited.count(i), 1u);
        }
      }
    }
  }
}

TEST(PlaceIndex, AVisitEndsWhereItReturnsTrue) {
  PlaceIndex places;
  places.clear(10, 10);
  for (int i = 0; i < 10; ++i) places.add(5, 5);
  int visits = 0;
  EXPECT_TRUE(places.visitNear(5, 5, 1, 1, [&](std::uint32_t) { return ++visits == 3; }));
  EXPECT_EQ(visits, 3);
}

}  // namespace
}  // namespace corrsel::core
