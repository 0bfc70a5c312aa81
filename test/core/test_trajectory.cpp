#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "datasets/trajectory.h"

namespace corrsel::core {
namespace {

Trajectory straight() {
  Trajectory poses;
  for (const std::int64_t time : {100, 110, 120, 200}) {
    poses.add(time, motionOf(1, 0, 0, 0, {static_cast<double>(time), 0, 0}));
  }
  return poses;
}

TEST(Trajectory, InterpolatesBetweenNeighbours) {
  const Trajectory poses = straight();
  EXPECT_EQ(poses.at(110, 0)->translation[0], 110);
  EXPECT_NEAR(poses.at(113, 10)->translation[0], 113, 1e-12);
  EXPECT_TRUE(poses.at(113, 7).has_value());
  EXPECT_FALSE(poses.at(113, 6).has_value());  // the pose after it is 7 away
}

TEST(Trajectory, HasNoPoseInGapsAndBeyondItsEnds) {
  const Trajectory poses = straight();
  EXPECT_FALSE(poses.at(160, 30).has_value());
  EXPECT_TRUE(poses.at(160, 40).has_value());
  EXPECT_FALSE(poses.at(99, 1000).has_value());
  EXPECT_FALSE(poses.at(201, 1000).has_value());
  EXPECT_FALSE(Trajectory().at(1, 1000).has_value());
  EXPECT_TRUE(Trajectory().empty());
}

}  // namespace
}  // namespace corrsel::core
