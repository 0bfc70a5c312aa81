#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/ros/pose.h"

namespace corrsel {
namespace {

using core::Motion;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Matrix5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PairInfo exampleInfo() {
  PairInfo info;
  info.header.stamp = ros::Time(12, 34);
  info.header.frame_id = "left_camera_optical";
  info.right_stamp = ros::Time(12, 99);
  info.right_frame_id = "right_camera_optical";
  return info;
}

Eigen::Matrix3d exponential(const Eigen::Vector3d& w) {
  return w.isZero() ? Eigen::Matrix3d::Identity()
                    : Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
}

cv::Matx33d matx(const Eigen::Matrix3d& matrix) {
  cv::Matx33d result;
  Eigen::Map<Matrix3>(result.val) = matrix;
  return result;
}

Eigen::Vector3d eigen(const cv::Vec3d& v) { return {v[0], v[1], v[2]}; }
Eigen::Vector3d eigen(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }
Eigen::Vector3d eigen(const geometry_msgs::Point& v) { return {v.x, v.y, v.z}; }
Eigen::Quaterniond eigen(const geometry_msgs::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

/// Rotation and direction of the specification's golden numbers, and a full covariance.
core::PoseResult example(Motion motion) {
  core::PoseResult result;
  result.motion = motion;
  result.noise = 0.75;
  result.parallax = 12.5;
  if (motion == Motion::kNone) return result;
  if (motion != Motion::kRest) result.pose.rotation = matx(exponential({0.10, -0.20, 0.05}));
  Matrix5 factor;
  for (int i = 0; i < 25; ++i) factor(i / 5, i % 5) = std::sin(1.0 + i * i);
  const Matrix5 covariance = 1e-6 * (factor * factor.transpose());
  std::copy_n(covariance.data(), 25, result.covariance.val);
  if (motion == Motion::kGeneral || motion == Motion::kPlanar) {
    result.pose.translation = cv::normalize(cv::Vec3d(1, 0.5, -0.25));
    return result;
  }
  for (int i = 0; i < 5; ++i) {
    for (const int k : {3, 4}) result.covariance(i, k) = result.covariance(k, i) = kNaN;
  }
  return result;
}

core::PoseResult withSecond() {
  core::PoseResult result = example(Motion::kPlanar);
  result.second = core::Pose{matx(exponential({-0.2, 0.1, 0.3})), cv::normalize(cv::Vec3d(-1, 2, 2))};
  return result;
}

core::Selection selectionOf(const core::PoseResult& pose) {
  core::Selection selection;
  selection.confidence = 20.5;
  selection.pose = pose;
  return selection;
}

RelativePose message(const core::PoseResult& pose, const PairInfo& info = exampleInfo()) {
  return toPoseMsg(selectionOf(pose), info, "pose");
}

void expectNear(const cv::Matx33d& a, const cv::Matx33d& b) {
  EXPECT_LT(cv::norm(a - b, cv::NORM_INF), 1e-14) << a << b;
}

void expectSame(const core::PoseResult& a, const core::PoseResult& b) {
  EXPECT_EQ(a.motion, b.motion);
  expectNear(a.pose.rotation, b.pose.rotation);
  EXPECT_LT(cv::norm(a.pose.translation - b.pose.translation), 1e-14);
  for (int i = 0; i < 25; ++i) {
    if (std::isnan(b.covariance.val[i])) {
      EXPECT_TRUE(std::isnan(a.covariance.val[i])) << i;
    } else {
      EXPECT_EQ(a.covariance.val[i], b.covariance.val[i]) << i;
    }
  }
  EXPECT_EQ(a.uncertain, b.uncertain);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(a.parallax, b.parallax);
  ASSERT_EQ(a.second.has_value(), b.second.has_value());
  if (!a.second) return;
  expectNear(a.second->rotation, b.second->rotation);
  EXPECT_LT(cv::norm(a.second->translation - b.second->translation), 1e-14);
}

TEST(RelativePoseMessage, RoundTripKeepsEverything) {
  for (const Motion motion :
       {Motion::kNone, Motion::kRest, Motion::kRotation, Motion::kGeneral, Motion::kPlanar}) {
    SCOPED_TRACE(core::toString(motion));
    core::PoseResult result = motion == Motion::kPlanar ? withSecond() : example(motion);
    result.uncertain = motion == Motion::kRotation;
    PairInfo info;
    const RelativePose msg = message(result);
    expectSame(fromMsg(msg, &info), result);
    EXPECT_EQ(info.header.stamp, exampleInfo().header.stamp);
    EXPECT_EQ(info.header.frame_id, "left_camera_optical");
    EXPECT_EQ(info.right_stamp, exampleInfo().right_stamp);
    EXPECT_EQ(info.right_frame_id, "right_camera_optical");
    EXPECT_FALSE(info.rig);
    EXPECT_EQ(msg.selector, "pose");
    EXPECT_EQ(msg.confidence, 20.5);
    EXPECT_EQ(msg.status, Selection::STATUS_OK);
  }
}

TEST(RelativePoseMessage, RotationTakesPointsFromLeftToRight) {
  const core::PoseResult result = example(Motion::kGeneral);
  const RelativePose msg = message(result);
  const cv::Vec3d point(0.3, -1.1, 6);
  const Eigen::Vector3d turned = eigen(msg.rotation) * eigen(point);
  EXPECT_LT((turned - eigen(result.pose.rotation * point)).norm(), 1e-14);
  EXPECT_GE(msg.rotation.w, 0);
  // b1 = t x e / |t x e| with the axis e of the smallest |t_i|, b2 = t x b1.
  const Eigen::Vector3d t = eigen(msg.translation);
  EXPECT_LT((eigen(msg.basis_a) - t.cross(Eigen::Vector3d::UnitZ()).normalized()).norm(), 1e-14);
  EXPECT_LT((eigen(msg.basis_b) - t.cross(eigen(msg.basis_a))).norm(), 1e-14);
  EXPECT_TRUE(std::isnan(msg.scale));
}

TEST(RelativePoseMessage, WhatIsUndefinedIsNaN) {
  const RelativePose none = message(example(Motion::kNone));
  for (const double number :
       {none.rotation.x, none.rotation.w, none.translation.x, none.covariance[0], none.basis_a.x,
        none.second_rotation.w, none.second_translation.z, none.scale}) {
    EXPECT_TRUE(std::isnan(number));
  }
  const RelativePose rest = message(example(Motion::kRest));
  EXPECT_EQ(rest.rotation.w, 1);
  EXPECT_EQ(rest.translation.x, 0);
  EXPECT_TRUE(std::isnan(rest.basis_a.x));
  EXPECT_TRUE(std::isnan(rest.covariance[24]));
  EXPECT_FALSE(std::isnan(rest.covariance[0]));
}

TEST(RelativePoseMessage, EveryMotionHasItsConstant) {
  EXPECT_EQ(static_cast<int>(Motion::kNone), RelativePose::MOTION_NONE);
  EXPECT_EQ(static_cast<int>(Motion::kRest), RelativePose::MOTION_REST);
  EXPECT_EQ(static_cast<int>(Motion::kRotation), RelativePose::MOTION_ROTATION);
  EXPECT_EQ(static_cast<int>(Motion::kGeneral), RelativePose::MOTION_GENERAL);
  EXPECT_EQ(static_cast<int>(Motion::kPlanar), RelativePose::MOTION_PLANAR);
}

TEST(RelativePoseMessage, NonsenseIsNamed) {
  const auto refused = [](const std::function<void(RelativePose&)>& damage, const std::string& field) {
    RelativePose msg = message(withSecond());
    damage(msg);
    try {
      fromMsg(msg);
      ADD_FAILURE() << "accepted, expected a complaint about " << field;
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(std::string(error.what()).rfind("RelativePose message: " + field, 0), 0u) << error.what();
    }
  };
  refused([](RelativePose& m) { m.status = 9; }, "status");
  refused([](RelativePose& m) { m.motion = 5; }, "motion");
  refused([](RelativePose& m) { m.rotation.w += 0.1; }, "rotation");
  refused([](RelativePose& m) { m.rotation.x = kNaN; }, "rotation");
  refused([](RelativePose& m) { m.translation.x += 0.1; }, "translation");
  refused([](RelativePose& m) { m.translation = geometry_msgs::Vector3(); }, "translation");
  refused([](RelativePose& m) { m.motion = RelativePose::MOTION_ROTATION; }, "translation");
  refused([](RelativePose& m) { m.second_rotation = geometry_msgs::Quaternion(); }, "second_rotation");
  refused([](RelativePose& m) { m.second_translation.y = kNaN; }, "second_translation");
  refused([](RelativePose& m) { m.noise = -1; }, "noise");
  refused([](RelativePose& m) { m.parallax = -1; }, "parallax");
  refused([](RelativePose& m) { m.scale = -1; }, "scale");
  refused([](RelativePose& m) { m.scale_known = 1; }, "scale");
}

/// Position and orientation of the right camera in the left one's frame, of length 1.
Eigen::Isometry3d inverse(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = translation;
  return pose.inverse();
}

Matrix6 covarianceOf(const geometry_msgs::PoseWithCovarianceStamped& pose) {
  return Eigen::Map<const Matrix6>(pose.pose.covariance.data());
}

TEST(PoseOfRight, IsTheInverseInTheLeftFrame) {
  const core::PoseResult result = example(Motion::kGeneral);
  const auto pose = poseOfRight(message(result));
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->header.stamp, exampleInfo().header.stamp);
  EXPECT_EQ(pose->header.frame_id, "left_camera_optical");
  const Eigen::Vector3d centre = eigen(pose->pose.pose.position);
  const cv::Vec3d in_right =
      result.pose.rotation * cv::Vec3d(centre.x(), centre.y(), centre.z()) + result.pose.translation;
  EXPECT_LT(cv::norm(in_right), 1e-14) << "the right camera stands at the origin of its frame";
  const cv::Vec3d point(0.3, -1.1, 6);
  const Eigen::Vector3d right = eigen(result.pose.rotation * point + result.pose.translation);
  EXPECT_LT((eigen(pose->pose.pose.orientation) * right + centre - eigen(point)).norm(), 1e-13);
}

// The covariance is compared with that of central differences of the inverse pose.
TEST(PoseOfRight, CovarianceFollowsFromThatOfTheMotion) {
  const core::PoseResult result = example(Motion::kGeneral);
  const RelativePose msg = message(result);
  const auto pose = poseOfRight(msg);
  ASSERT_TRUE(pose);
  const Eigen::Matrix3d rotation = eigen(msg.rotation).toRotationMatrix();
  const Eigen::Vector3d t = eigen(msg.translation), a = eigen(msg.basis_a), b = eigen(msg.basis_b);
  const Eigen::Isometry3d centre = inverse(rotation, t);
  constexpr double kStep = 1e-5;
  Eigen::Matrix<double, 6, 5> jacobian;
  const auto moved = [&](int parameter, double step) {
    Eigen::Matrix<double, 5, 1> x = Eigen::Matrix<double, 5, 1>::Zero();
    x[parameter] = step;
    const Eigen::Isometry3d other =
        inverse(exponential(x.head<3>()) * rotation, (t + x[3] * a + x[4] * b).normalized());
    // Rotations about the fixed axes are multiplied from the left.
    const Eigen::AngleAxisd turned(Eigen::Matrix3d(other.linear() * centre.linear().transpose()));
    Eigen::Matrix<double, 6, 1> difference;
    difference << other.translation() - centre.translation(), turned.angle() * turned.axis();
    return difference;
  };
  for (int i = 0; i < 5; ++i) jacobian.col(i) = (moved(i, kStep) - moved(i, -kStep)) / (2 * kStep);
  const Eigen::Map<const Matrix5> given(msg.covariance.data());
  const Eigen::Vector3d along = centre.translation().normalized();
  Matrix6 expected = jacobian * given * jacobian.transpose();
  const double largest = expected.cwiseAbs().maxCoeff();
  Matrix6 actual = covarianceOf(*pose);
  EXPECT_NEAR(along.dot(actual.topLeftCorner<3, 3>() * along), kUnknownVariance, 1e-6);
  actual.topLeftCorner<3, 3>() -= kUnknownVariance * along * along.transpose();
  EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 1e-4 * largest) << actual << "\n\n" << expected;
}

void expectUnknown(const geometry_msgs::PoseWithCovarianceStamped& pose, int first, int last) {
  const Matrix6 covariance = covarianceOf(pose);
  for (int i = first; i < last; ++i) {
    for (int k = 0; k < 6; ++k) {
      EXPECT_EQ(covariance(i, k), i == k ? kUnknownVariance : 0.0) << i << " " << k;
      EXPECT_EQ(covariance(k, i), i == k ? kUnknownVariance : 0.0) << i << " " << k;
    }
  }
}

TEST(PoseOfRight, WithoutATranslationThePositionIsUnknown) {
  for (const Motion motion : {Motion::kRest, Motion::kRotation}) {
    SCOPED_TRACE(core::toString(motion));
    const core::PoseResult result = example(motion);
    const auto pose = poseOfRight(message(result));
    ASSERT_TRUE(pose);
    EXPECT_EQ(eigen(pose->pose.pose.position).norm(), 0);
    const double w = motion == Motion::kRest ? 1.0 : message(result).rotation.w;
    EXPECT_EQ(pose->pose.pose.orientation.w, w) << "turning back takes the same angle";
    expectUnknown(*pose, 0, 3);
    const Eigen::Map<const Matrix3> rotation(result.pose.rotation.val);
    const Matrix5 given = Eigen::Map<const Matrix5>(result.covariance.val);
    const Eigen::Matrix3d expected = rotation.transpose() * given.topLeftCorner<3, 3>() * rotation;
    EXPECT_LT((covarianceOf(*pose).bottomRightCorner<3, 3>() - expected).norm(), 1e-18);
  }
}

TEST(PoseOfRight, WhereNoCovarianceHoldsAllIsUnknown) {
  expectUnknown(*poseOfRight(message(withSecond())), 0, 6);
  core::PoseResult result = example(Motion::kGeneral);
  result.uncertain = true;
  expectUnknown(*poseOfRight(message(result)), 0, 6);
  result = example(Motion::kGeneral);
  result.covariance = cv::Matx<double, 5, 5>::all(kNaN);
  expectUnknown(*poseOfRight(message(result)), 0, 6);
}

TEST(PoseOfRight, IsNotThereWhereItIsNotToBeReliedOn) {
  EXPECT_FALSE(poseOfRight(message(example(Motion::kNone))));
  for (int status = 0; status <= Selection::STATUS_UNCERTAIN; ++status) {
    RelativePose msg = message(example(Motion::kGeneral));
    msg.status = static_cast<std::uint8_t>(status);
    EXPECT_EQ(poseOfRight(msg).has_value(),
              status == Selection::STATUS_OK || status == Selection::STATUS_TIME_LIMIT)
        << status;
  }
}

TEST(PoseOfRight, NothingIsEstimatedThatARigKnows) {
  PairInfo info = exampleInfo();
  info.rig = RigPose{matx(exponential({0, 0.01, 0})), {-0.12, 0.003, 0.01}};
  const double length = cv::norm(info.rig->translation);
  for (const core::PoseResult& result : {withSecond(), example(Motion::kRotation)}) {
    const RelativePose msg = message(result, info);
    EXPECT_TRUE(msg.scale_known);
    EXPECT_NEAR(msg.scale, length, 1e-15);
    EXPECT_FALSE(msg.has_second);
    EXPECT_EQ(msg.noise, 0.75) << "what the matches show";
    EXPECT_EQ(msg.motion, static_cast<std::uint8_t>(result.motion));
    PairInfo back;
    expectNear(fromMsg(msg, &back).pose.rotation, info.rig->rotation);
    ASSERT_TRUE(back.rig);
    expectNear(back.rig->rotation, info.rig->rotation);
    EXPECT_LT(cv::norm(back.rig->translation - info.rig->translation), 1e-15);
    const auto pose = poseOfRight(msg);
    ASSERT_TRUE(pose);
    const Eigen::Vector3d centre = eigen(pose->pose.pose.position);
    EXPECT_NEAR(centre.norm(), length, 1e-15);
    EXPECT_LT(
        (Eigen::Map<const Matrix3>(info.rig->rotation.val) * centre + eigen(info.rig->translation)).norm(),
        1e-15);
    EXPECT_EQ(covarianceOf(*pose).norm(), 0);
  }
  // A message of somebody who knows the scale alone.
  RelativePose msg = message(example(Motion::kGeneral));
  const Matrix6 unit = covarianceOf(*poseOfRight(msg));
  msg.scale_known = 1;
  msg.scale = 2.5;
  const Matrix6 scaled = covarianceOf(*poseOfRight(msg));
  const Eigen::Vector3d along = eigen(poseOfRight(msg)->pose.pose.position).normalized();
  EXPECT_NEAR(along.dot(scaled.topLeftCorner<3, 3>() * along), 0, 1e-18);
  EXPECT_LT((scaled.bottomLeftCorner<3, 3>() - 2.5 * unit.bottomLeftCorner<3, 3>()).norm(), 1e-15);
}

}  // namespace
}  // namespace corrsel
