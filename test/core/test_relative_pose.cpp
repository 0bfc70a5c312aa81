#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/test_support.h"
#include "corrsel/relative_pose.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

RelativePose example() {
  RelativePose pose;
  pose.left_camera = {700, 2, 320, 0, 710, 240, 0, 0, 1};
  pose.right_camera = {800, 0, 300, 0, 790, 200, 0, 0, 1};
  const double angle = 0.2;
  pose.rotation = {std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)};
  pose.translation = {0.4, -0.1, 0.05};
  return pose;
}

cv::Vec3d project(const cv::Matx33d& camera, const cv::Vec3d& point) {
  const cv::Vec3d x = camera * point;
  return x * (1.0 / x[2]);
}

TEST(RelativePose, ImagesOfAPointFulfilTheEpipolarConstraint) {
  const RelativePose pose = example();
  const cv::Matx33d f = pose.fundamental();
  EXPECT_NEAR(cv::norm(f), 1.0, 1e-12);
  for (const cv::Vec3d& point : {cv::Vec3d(0.3, -0.2, 4), cv::Vec3d(-1, 0.5, 7), cv::Vec3d(0, 0, 2)}) {
    const cv::Vec3d left = project(pose.left_camera, point);
    const cv::Vec3d right = project(pose.right_camera, pose.rotation * point + pose.translation);
    EXPECT_NEAR(right.dot(f * left), 0.0, 1e-9);
    EXPECT_GT(std::abs(right.dot(f * (left + cv::Vec3d(20, 20, 0)))), 1e-4);
  }
}

TEST(RelativePose, GoodPosesPass) {
  EXPECT_NO_THROW(example().check());
  RelativePose turned = example();
  turned.translation = {0, 0, 0};
  EXPECT_NO_THROW(turned.check());
}

TEST(RelativePose, FaultsAreNamed) {
  RelativePose pose = example();
  pose.left_camera(0, 0) = 0;
  EXPECT_TRUE(contains(errorOf([&] { pose.check(); }),
                       "left_camera = [0 2 320; 0 710 240; 0 0 1] is not a camera matrix"));
  pose = example();
  pose.right_camera = pose.right_camera.t();
  EXPECT_TRUE(contains(errorOf([&] { pose.check(); }), "right_camera = "));
  pose = example();
  pose.translation[1] = std::nan("");
  EXPECT_TRUE(contains(errorOf([&] { pose.check(); }), "translation"));
  pose = example();
  pose.rotation(0, 0) += 0.01;
  EXPECT_TRUE(contains(errorOf([&] { pose.check(); }), "is not a rotation"));
  pose = example();
  pose.rotation = -pose.rotation;
  EXPECT_TRUE(contains(errorOf([&] { pose.check(); }), "is not a rotation"));
  pose = example();
  pose.translation = {0, 0, 0};
  EXPECT_TRUE(
      contains(errorOf([&] { pose.fundamental(); }), "a camera that only turned has no fundamental matrix"));
}

}  // namespace
}  // namespace corrsel::core
