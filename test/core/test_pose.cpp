#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "corrsel/evaluation/pose.h"
#include "corrsel/random.h"
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

/// exp([w]_x)
cv::Matx33d exponential(const cv::Vec3d& w) {
  const double angle = cv::norm(w);
  const cv::Vec3d n = w / angle;
  const cv::Matx33d cross(0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0);
  return cv::Matx33d::eye() + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
}

TEST(PoseDeviation, IsInTheParametersOfTheCovariance) {
  const Pose estimate{turn(20), cv::normalize(cv::Vec3d(0.3, -0.2, 0.9))};
  const cv::Vec3d w(0.01, -0.02, 0.03);
  cv::Vec3d b1, b2;
  translationBasis(estimate.translation, b1, b2);
  RelativePose truth;
  truth.rotation = exponential(w) * estimate.rotation;
  truth.translation = 7 * (estimate.translation + 1e-3 * b1 - 2e-3 * b2);
  const cv::Vec<double, 5> error = poseDeviation(estimate, truth);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(error[i], w[i], 1e-12) << i;
  EXPECT_NEAR(error[3], 1e-3, 1e-8);
  EXPECT_NEAR(error[4], -2e-3, 1e-8);
  // Large errors are angles, too.
  truth.translation = std::cos(2.5) * estimate.translation + std::sin(2.5) * b2;
  EXPECT_NEAR(poseDeviation(estimate, truth)[4], 2.5, 1e-12);
  truth.translation = -estimate.translation;
  EXPECT_NEAR(cv::norm(cv::Vec2d(poseDeviation(estimate, truth)[3], poseDeviation(estimate, truth)[4])),
              CV_PI, 1e-9);
  truth.rotation = exponential({0, CV_PI, 0}) * estimate.rotation;
  EXPECT_NEAR(std::abs(poseDeviation(estimate, truth)[1]), CV_PI, 1e-7);
  truth.rotation = estimate.rotation;
  truth.translation = {};
  EXPECT_NEAR(cv::norm(poseDeviation(estimate, truth).get_minor<3, 1>(0, 0)), 0, 1e-12);
  EXPECT_TRUE(std::isnan(poseDeviation(estimate, truth)[3]));
}

/// A pose with the given standard deviations of its parameters.
PoseResult estimateWith(const cv::Vec<double, 5>& deviations) {
  PoseResult result;
  result.motion = Motion::kGeneral;
  result.pose = {turn(10), {0, 0, 1}};
  result.covariance = cv::Matx<double, 5, 5>::zeros();
  for (int i = 0; i < 5; ++i) result.covariance(i, i) = deviations[i] * deviations[i];
  return result;
}

TEST(NormalizedError, ByHand) {
  const PoseResult estimate = estimateWith({0.01, 0.02, 0.01, 0.1, 0.05});
  cv::Vec3d b1, b2;
  translationBasis(estimate.pose.translation, b1, b2);
  RelativePose truth;
  truth.rotation = exponential({0, 0.06, 0}) * estimate.pose.rotation;  // 3 standard deviations
  truth.translation = std::cos(0.1) * estimate.pose.translation + std::sin(0.1) * b1;
  const NormalizedError error = normalizedError(estimate, truth);
  EXPECT_NEAR(error.squared, 9 + 1, 1e-9);
  EXPECT_EQ(error.degrees, 5u);
  EXPECT_TRUE(error.inside());
  truth.translation = std::cos(0.1) * estimate.pose.translation + std::sin(0.1) * b2;
  EXPECT_NEAR(normalizedError(estimate, truth).squared, 9 + 4, 1e-9);
  EXPECT_FALSE(normalizedError(estimate, truth).inside());
}

TEST(NormalizedError, UsesCorrelations) {
  PoseResult estimate = estimateWith({1, 1, 1, 1, 1});
  estimate.covariance(0, 1) = estimate.covariance(1, 0) = 0.9;
  RelativePose truth;
  truth.translation = {0, 0, 1};
  truth.rotation = exponential({0.1, 0.1, 0}) * estimate.pose.rotation;
  EXPECT_NEAR(normalizedError(estimate, truth).squared, 0.02 / 1.9, 1e-9);
  truth.rotation = exponential({0.1, -0.1, 0}) * estimate.pose.rotation;
  EXPECT_NEAR(normalizedError(estimate, truth).squared, 0.02 / 0.1, 1e-9);
}

TEST(NormalizedError, OfRotationsHasThreeDegrees) {
  PoseResult estimate = estimateWith({0.01, 0.01, 0.01, NAN, NAN});
  estimate.motion = Motion::kRotation;
  estimate.pose.translation = {};
  RelativePose truth;
  truth.rotation = exponential({0.02, 0.01, 0.01}) * estimate.pose.rotation;
  NormalizedError error = normalizedError(estimate, truth);
  EXPECT_NEAR(error.squared, 6, 1e-9);
  EXPECT_EQ(error.degrees, 3u);
  EXPECT_TRUE(error.inside());
  truth.rotation = exponential({0.02, 0.02, 0.01}) * estimate.pose.rotation;
  EXPECT_FALSE(normalizedError(estimate, truth).inside());
  truth.translation = {1, 0, 0};  // the verdict is wrong
  EXPECT_EQ(normalizedError(estimate, truth).degrees, 0u);
}

TEST(NormalizedError, IsUndefinedWithoutCovariance) {
  RelativePose truth;
  truth.translation = {0, 0, 1};
  PoseResult none = estimateWith({1, 1, 1, 1, 1});
  none.motion = Motion::kNone;
  PoseResult indefinite = estimateWith({1, 1, 1, 1, 1});
  indefinite.covariance(2, 2) = -1;
  for (const PoseResult& estimate : {none, indefinite, estimateWith({1, 1, NAN, 1, 1})}) {
    const NormalizedError error = normalizedError(estimate, truth);
    EXPECT_TRUE(std::isnan(error.squared));
    EXPECT_EQ(error.degrees, 0u);
    EXPECT_FALSE(error.inside());
  }
}

TEST(NormalizedError, MeanIsTheNumberOfDegrees) {
  const cv::Vec<double, 5> deviations(0.01, 0.005, 0.02, 0.03, 0.01);
  const PoseResult estimate = estimateWith(deviations);
  cv::Vec3d b1, b2;
  translationBasis(estimate.pose.translation, b1, b2);
  Random random(4);
  constexpr int kTrials = 20000;
  double sum = 0;
  int inside = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    cv::Vec<double, 5> e;
    for (int i = 0; i < 5; ++i) e[i] = deviations[i] * random.normal();
    RelativePose truth;
    truth.rotation = exponential({e[0], e[1], e[2]}) * estimate.pose.rotation;
    truth.translation = estimate.pose.translation + e[3] * b1 + e[4] * b2;
    const NormalizedError error = normalizedError(estimate, truth);
    sum += error.squared;
    inside += error.inside() ? 1 : 0;
  }
  EXPECT_NEAR(sum / kTrials, 5, 0.1);  // four standard deviations
  EXPECT_NEAR(static_cast<double>(inside) / kTrials, 0.95, 0.006);
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
