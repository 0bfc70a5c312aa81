#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "corrsel/evaluation/pose.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

constexpr double kInf = std::numeric_limits<double>::infinity();

/// Turns by an angle about y.
cv::Matx33d turn(double degrees) {
  const double c = std::cos(degrees * CV_PI / 180), s = std::sin(degrees * CV_PI / 180);
  return {c, 0, s, 0, 1, 0, -s, 0, c};
}

RelativePose truthOf(double degrees, const cv::Vec3d& translation) {
  RelativePose truth;
  truth.rotation = turn(degrees);
  truth.translation = translation;
  return truth;
}

TEST(Pose, ErrorsAreAngles) {
  const RelativePose truth = truthOf(10, {2, 0, 0});
  const PoseErrors errors = poseErrors(turn(13), {std::cos(0.1), std::sin(0.1), 0}, truth);
  EXPECT_NEAR(errors.rotation, 3, 1e-9);
  EXPECT_NEAR(errors.translation, 0.1 * 180 / CV_PI, 1e-9);
  EXPECT_EQ(errors.pose, errors.translation);
  EXPECT_NEAR(poseErrors(turn(20), {1, 0, 0}, truth).pose, 10, 1e-9);
  // The cosine of so small an angle is 1.
  EXPECT_NEAR(poseErrors(turn(10 + 1e-7), {1, 1e-9, 0}, truth).rotation, 1e-7, 1e-12);
  EXPECT_NEAR(poseErrors(turn(10), {1, 1e-9, 0}, truth).translation, 1e-9 * 180 / CV_PI, 1e-15);
  EXPECT_NEAR(poseErrors(turn(190), {1, 0, 0}, truth).rotation, 180, 1e-6);
}

TEST(Pose, SignOfTheTranslationIsNotCompared) {
  const RelativePose truth = truthOf(0, {0, 0, 3});
  EXPECT_NEAR(poseErrors(turn(0), {0, 0, -1}, truth).pose, 0, 1e-12);
  EXPECT_NEAR(poseErrors(turn(0), {0, std::sin(2.0), std::cos(2.0)}, truth).translation,
              180 - 2 * 180 / CV_PI, 1e-9);
}

TEST(Pose, CameraThatOnlyTurned) {
  const PoseErrors errors = poseErrors(turn(4), {0, 1, 0}, truthOf(0, {0, 0, 0}));
  EXPECT_NEAR(errors.pose, 4, 1e-9);
  EXPECT_TRUE(std::isnan(errors.translation));
  const PoseErrors none = poseErrors(turn(4), {0, 0, 0}, truthOf(0, {1, 0, 0}));
  EXPECT_NEAR(none.rotation, 4, 1e-9);
  EXPECT_EQ(none.pose, kFailedPose);
}

TEST(Pose, TrueMotions) {
  EXPECT_EQ(trueMotion(truthOf(0, {0, 0, 0})), Motion::kRest);
  EXPECT_EQ(trueMotion(truthOf(1e-3, {0, 0, 0})), Motion::kRotation);
  EXPECT_EQ(trueMotion(truthOf(0, {0, 1e-3, 0})), Motion::kGeneral);
}

TEST(Pose, AreaUnderTheCurveByHand) {
  // Up to 1: a triangle of height 1/3. From 1 to 3: the mean of 1/3 and 2/3. From 3 to 5: 2/3.
  EXPECT_DOUBLE_EQ(errorAuc({10, 1, 3}, 5), (1.0 / 6 + 2.0 / 2 + 2 * 2.0 / 3) / 5);
  EXPECT_DOUBLE_EQ(errorAuc({0, 0}, 5), 1);
  EXPECT_DOUBLE_EQ(errorAuc({2, 2}, 4), (2 * 0.25 + 2 * 1) / 4);  // equal errors: a vertical line
  EXPECT_DOUBLE_EQ(errorAuc({kFailedPose, kInf}, 20), 0);
  EXPECT_DOUBLE_EQ(errorAuc({5}, 5), 0);  // at the threshold is not below it
  EXPECT_TRUE(std::isnan(errorAuc({}, 5)));
}

TEST(Pose, ErrorsThatAreNoneAreRefused) {
  EXPECT_TRUE(contains(errorOf([] { errorAuc({1, std::nan("")}, 5); }), "error = NaN"));
  EXPECT_TRUE(contains(errorOf([] { errorAuc({-1}, 5); }), "error = -1"));
  EXPECT_TRUE(contains(errorOf([] { errorAuc({1}, 0); }), "threshold = 0"));
}

TEST(Pose, BootstrapOfTheArea) {
  std::vector<std::vector<double>> pairs;
  std::vector<double> all;
  for (int i = 0; i < 200; ++i) {
    all.push_back(i % 4 == 0 ? kFailedPose : 0.05 * (i % 60));
    pairs.push_back({all.back()});
  }
  const double area = errorAuc(all, 5);
  const Interval interval = bootstrapAuc(pairs, 5, 1);
  EXPECT_LT(interval.low, area);
  EXPECT_GT(interval.high, area);
  // The area is nearly the mean of 1 - error / 5 where that is positive.
  std::vector<double> shares;
  for (const double error : all) shares.push_back(std::max(0.0, 1 - error / 5));
  const Interval of_means = bootstrapMean(shares, 1);
  EXPECT_NEAR(interval.low, of_means.low, 0.01);
  EXPECT_NEAR(interval.high, of_means.high, 0.01);
  const Interval one = bootstrapAuc({{1, 3, 10}}, 5, 1);
  EXPECT_DOUBLE_EQ(one.low, errorAuc({1, 3, 10}, 5));
  EXPECT_DOUBLE_EQ(one.high, one.low);
  EXPECT_TRUE(std::isnan(bootstrapAuc({}, 5, 1).low));
}

TEST(Pose, AccuracyIsTheShareOfThresholds) {
  EXPECT_DOUBLE_EQ(thresholdAccuracy(0.5), 1);
  EXPECT_DOUBLE_EQ(thresholdAccuracy(1), 0.9);
  EXPECT_DOUBLE_EQ(thresholdAccuracy(9.99), 0.1);
  EXPECT_DOUBLE_EQ(thresholdAccuracy(kFailedPose), 0);
  EXPECT_DOUBLE_EQ(thresholdAccuracy(2, {1, 3, 5}), 2.0 / 3);
}

TEST(Pose, EpipolarDistancesOfASidewaysStep) {
  RelativePose truth = truthOf(0, {1, 0, 0});
  truth.left_camera = truth.right_camera = {100, 0, 50, 0, 100, 40, 0, 0, 1};
  Correspondences matches;
  matches.add({10, 20}, {5, 20});
  matches.add({10, 20}, {5, 23});  // 0.03 from its line in either image
  matches.add({10, 20}, {std::nanf(""), 20});
  const std::vector<double> errors = epipolarErrors(truth, matches);
  EXPECT_NEAR(errors[0], 0, 1e-20);
  EXPECT_NEAR(errors[1], 2 * 0.03 * 0.03, 1e-12);
  EXPECT_EQ(errors[2], kInf);
  EXPECT_DOUBLE_EQ(epipolarPrecision(errors, {1, 1, 0}), 0.5);
  EXPECT_DOUBLE_EQ(epipolarPrecision(errors, {1, 1, 0}, 0.002), 1);
  EXPECT_DOUBLE_EQ(epipolarPrecision(errors, {0, 0, 0}), 0);
  EXPECT_TRUE(contains(errorOf([&] { epipolarPrecision(errors, {1}); }), "mask has 1 elements for 3"));
  truth.translation = {0, 0, 0};
  EXPECT_TRUE(contains(errorOf([&] { epipolarErrors(truth, matches); }), "only turned"));
}

TEST(Pose, CornersOfTheLeftImage) {
  const cv::Matx33d identity = cv::Matx33d::eye(), shift = {1, 0, 3, 0, 1, 4, 0, 0, 1};
  EXPECT_NEAR(cornerError(shift, identity, {101, 51}), 5, 1e-12);
  EXPECT_NEAR(cornerError(shift * -2.0, identity, {101, 51}), 5, 1e-12);  // the scale means nothing
  const cv::Matx33d wider = {2, 0, 0, 0, 1, 0, 0, 0, 1};  // moves the two right corners by 100
  EXPECT_NEAR(cornerError(wider, identity, {101, 51}), 50, 1e-12);
  const cv::Matx33d behind = {1, 0, 0, 0, 1, 0, -0.011, 0, 1};
  EXPECT_EQ(cornerError(behind, identity, {101, 51}), kInf);
  EXPECT_EQ(cornerError(cv::Matx33d::zeros(), identity, {101, 51}), kInf);
  EXPECT_TRUE(contains(errorOf([&] { cornerError(identity, identity, {}); }), "empty"));
}

}  // namespace
}  // namespace corrsel::core
