#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/rigid_motion.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

const double kHalf = std::sqrt(0.5);

TEST(RigidMotion, ComposesAndInverts) {
  const RigidMotion a = motionOf(kHalf, 0, 0, kHalf, {1, 2, 3});  // 90 degrees about z
  const RigidMotion b = motionOf(2, 2, 0, 0, {0, 0, 1});          // 90 degrees about x
  EXPECT_LT(cv::norm(a.rotation - cv::Matx33d(0, -1, 0, 1, 0, 0, 0, 0, 1)), 1e-15);
  EXPECT_LT(cv::norm(b.rotation - cv::Matx33d(1, 0, 0, 0, 0, -1, 0, 1, 0)), 1e-15);
  const RigidMotion both = a * b;  // b first: (0, 0, 0) -> (0, 0, 1) -> (1, 2, 4)
  EXPECT_LT(cv::norm(both.translation - cv::Vec3d(1, 2, 4)), 1e-15);
  const RigidMotion none = both * both.inverse();
  EXPECT_LT(cv::norm(none.rotation - cv::Matx33d::eye()), 1e-14);
  EXPECT_LT(cv::norm(none.translation), 1e-14);
}

TEST(RigidMotion, InterpolatesTurnAndPath) {
  const RigidMotion from = motionOf(1, 0, 0, 0, {0, 0, 0}), to = motionOf(kHalf, 0, kHalf, 0, {2, 0, 4});
  const RigidMotion third = interpolated(from, to, 1.0 / 3);
  EXPECT_NEAR(std::acos(third.rotation(0, 0)), CV_PI / 6, 1e-12);
  EXPECT_NEAR(third.rotation(0, 2), 0.5, 1e-12);
  EXPECT_LT(cv::norm(third.translation - cv::Vec3d(2, 0, 4) * (1.0 / 3)), 1e-15);
  EXPECT_LT(cv::norm(interpolated(from, to, 0).rotation - from.rotation), 1e-12);
  EXPECT_LT(cv::norm(interpolated(from, to, 1).rotation - to.rotation), 1e-12);
  // A quaternion and its opposite are the same rotation: the short way is taken.
  const RigidMotion opposite = motionOf(-kHalf, 0, -kHalf, 0, {2, 0, 4});
  EXPECT_LT(cv::norm(interpolated(from, opposite, 1.0 / 3).rotation - third.rotation), 1e-12);
}

TEST(RigidMotion, QuaternionsHaveADirection) {
  const auto errorFor = [](double w, double x, const cv::Vec3d& t) {
    return errorOf<std::invalid_argument>([&] { motionOf(w, x, 0, 0, t); });
  };
  EXPECT_EQ(errorFor(0, 0, {}), "the quaternion is 0 0 0 0, which is no rotation");
  EXPECT_EQ(errorFor(NAN, 1, {}), "the quaternion is nan 1 0 0, which is no rotation");
  EXPECT_EQ(errorFor(1, INFINITY, {}), "the quaternion is 1 inf 0 0, which is no rotation");
  EXPECT_EQ(errorFor(1, 0, {0, NAN, 1}), "the translation is 0 nan 1, which is not finite");
}

TEST(RigidMotion, MatricesOfFewDigitsBecomeRotations) {
  const cv::Matx44d written(0.78593, -0.35128, 0.50884, -1.51061, 0.39215, 0.91944, 0.02904, -0.05367,
                            -0.47805, 0.17672, 0.86037, 0.056, 0, 0, 0, 1);
  const RigidMotion motion = motionOf(written);
  EXPECT_LT(cv::norm(motion.rotation * motion.rotation.t() - cv::Matx33d::eye()), 1e-14);
  EXPECT_LT(cv::norm(motion.rotation - written.get_minor<3, 3>(0, 0)), 1e-4);
  EXPECT_EQ(motion.translation, cv::Vec3d(-1.51061, -0.05367, 0.056));
  const auto errorAt = [&](int row, int column, double value) {
    cv::Matx44d wrong = written;
    wrong(row, column) = value;
    return errorOf<std::invalid_argument>([&] { motionOf(wrong); });
  };
  EXPECT_TRUE(contains(errorAt(3, 3, 0), "its last row is not 0 0 0 1"));
  EXPECT_TRUE(contains(errorAt(0, 0, 0.9), "its rotation is not one"));
  EXPECT_TRUE(contains(errorAt(0, 0, NAN), "its rotation is not one"));
  EXPECT_EQ(errorAt(1, 3, NAN), "the translation is -1.51061 nan 0.056, which is not finite");
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>(
                           [] { motionOf(cv::Matx44d(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)); }),
                       "its rotation is not one"));
}

}  // namespace
}  // namespace corrsel::core
