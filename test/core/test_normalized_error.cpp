#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "corrsel/evaluation/pose.h"
#include "corrsel/random.h"

namespace corrsel::core {
namespace {

/// Turns by an angle about y.
cv::Matx33d turn(double degrees) {
  const double c = std::cos(degrees * CV_PI / 180), s = std::sin(degrees * CV_PI / 180);
  return {c, 0, s, 0, 1, 0, -s, 0, c};
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

}  // namespace
}  // namespace corrsel::core
