#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "corrsel/evaluation/pose.h"
#include "corrsel/pose/estimator.h"
#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

RelativePose example() {
  RelativePose pose;
  pose.left_camera = {700, 0, 320, 0, 710, 240, 0, 0, 1};
  pose.right_camera = {800, 0, 300, 0, 790, 200, 0, 0, 1};
  cv::Rodrigues(cv::Vec3d(0.05, -0.12, 0.03), pose.rotation);
  pose.translation = {-0.8, 0.1, 0.2};
  return pose;
}

enum class Scene { kDeep, kPlane };

/// Images of points with noise (px), and behind them matches of random positions.
Correspondences matchesOf(const RelativePose& pose, Scene scene, int right, int wrong, double noise) {
  Random random(5);
  const auto jitter = [&] { return noise * random.uniform(-1.0, 1.0); };
  Correspondences matches;
  matches.left_size = {640, 480};
  matches.right_size = {600, 400};
  for (int i = 0; i < right; ++i) {
    const double x = random.uniform(-2.0, 2.0), y = random.uniform(-1.5, 1.5);
    const double depth = random.uniform(4.0, 12.0);
    const cv::Vec3d point(x, y, scene == Scene::kDeep ? depth : 6 + 0.5 * x);
    const cv::Vec3d a = pose.left_camera * point;
    const cv::Vec3d b = pose.right_camera * (pose.rotation * point + pose.translation);
    const double ax = a[0] / a[2] + jitter(), ay = a[1] / a[2] + jitter();
    const double bx = b[0] / b[2] + jitter(), by = b[1] / b[2] + jitter();
    matches.add(cv::Point2d(ax, ay), cv::Point2d(bx, by));
  }
  for (int i = 0; i < wrong; ++i) {
    const double ax = random.uniform(0.0, 640.0), ay = random.uniform(0.0, 480.0);
    const double bx = random.uniform(0.0, 600.0), by = random.uniform(0.0, 400.0);
    matches.add(cv::Point2d(ax, ay), cv::Point2d(bx, by));
  }
  return matches;
}

/// What the plane of the scene does, px.
cv::Matx33d planeHomography(const RelativePose& pose) {
  // z = 6 + x / 2: the normal n and the distance d of n . X = d.
  const cv::Vec3d n(-0.5, 0, 1);
  const double d = 6;
  return pose.right_camera * (pose.rotation + pose.translation * n.t() * (1 / d)) * pose.left_camera.inv();
}

PoseErrors errorsOf(const PoseEstimate& estimate, const RelativePose& truth) {
  return poseErrors(estimate.rotation, estimate.translation, truth);
}

TEST(PoseEstimator, FindsThePoseAmongOutliers) {
  const RelativePose truth = example();
  const PoseEstimate estimate = estimatePose(matchesOf(truth, Scene::kDeep, 300, 200, 0.3), truth);
  EXPECT_EQ(estimate.model, PoseModel::kEssential);
  EXPECT_LT(errorsOf(estimate, truth).pose, 0.5);
  EXPECT_GT(estimate.translation.dot(truth.translation), 0);  // the points lie in front of both cameras
  EXPECT_NEAR(cv::norm(estimate.translation), 1, 1e-9);
  EXPECT_GE(estimate.n_inliers, 280u);
  EXPECT_LE(estimate.n_inliers, 320u);
}

TEST(PoseEstimator, RefinementUsesAllInliers) {
  // Without noise the answer is exact up to the single precision of the coordinates.
  const RelativePose truth = example();
  EXPECT_LT(errorsOf(estimatePose(matchesOf(truth, Scene::kDeep, 200, 0, 0), truth), truth).pose, 1e-3);
  // Five points alone would be off by degrees at this noise; a least-squares fit of many is not.
  const PoseEstimate estimate = estimatePose(matchesOf(truth, Scene::kDeep, 2000, 0, 0.5), truth);
  EXPECT_LT(errorsOf(estimate, truth).pose, 0.15);
}

TEST(PoseEstimator, SameMatchesGiveTheSameBits) {
  const RelativePose truth = example();
  const Correspondences matches = matchesOf(truth, Scene::kDeep, 150, 150, 0.5);
  const PoseEstimate first = estimatePose(matches, truth), second = estimatePose(matches, truth);
  EXPECT_EQ(first.rotation, second.rotation);
  EXPECT_EQ(first.translation, second.translation);
  EXPECT_EQ(estimateHomography(matches)->homography, estimateHomography(matches)->homography);
}

TEST(PoseEstimator, HomographyOfAPlaneIsDecomposed) {
  const RelativePose truth = example();
  const Correspondences matches = matchesOf(truth, Scene::kPlane, 200, 0, 0);
  for (const double scale : {1.0, -3.0}) {
    const PoseEstimate estimate = estimatePose(matches, truth, planeHomography(truth) * scale);
    EXPECT_EQ(estimate.model, PoseModel::kHomography) << scale;
    EXPECT_LT(errorsOf(estimate, truth).pose, 0.01) << scale;
    EXPECT_EQ(estimate.n_inliers, 200u) << scale;
  }
}

TEST(PoseEstimator, PoorHomographyDoesNoHarm) {
  const RelativePose truth = example();
  const Correspondences matches = matchesOf(truth, Scene::kDeep, 300, 100, 0.3);
  const PoseEstimate without = estimatePose(matches, truth);
  const PoseEstimate estimate = estimatePose(matches, truth, cv::Matx33d(1, 0, 40, 0, 1, -10, 1e-4, 0, 1));
  EXPECT_GE(estimate.n_inliers, without.n_inliers);
  EXPECT_LT(errorsOf(estimate, truth).pose, 0.5);
  // A homography that explains nothing.
  EXPECT_EQ(estimatePose(matches, truth, cv::Matx33d(0, 1, 900, 1, 0, -900, 0, 0, 1)).model,
            PoseModel::kEssential);
}

TEST(PoseEstimator, HomographyOfACameraThatOnlyTurned) {
  RelativePose truth = example();
  truth.translation = {0, 0, 0};
  const Correspondences matches = matchesOf(truth, Scene::kDeep, 100, 0, 0);
  const cv::Matx33d homography = truth.right_camera * truth.rotation * truth.left_camera.inv();
  const PoseEstimate estimate = estimatePose(matches, truth, homography);
  EXPECT_EQ(estimate.model, PoseModel::kHomography);
  EXPECT_EQ(cv::norm(estimate.translation), 0);
  EXPECT_LT(errorsOf(estimate, truth).pose, 1e-3);
}

TEST(PoseEstimator, DegenerateMatchesGiveNoPoseAndNoException) {
  const RelativePose truth = example();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Correspondences good = matchesOf(truth, Scene::kDeep, 8, 0, 0);
  Correspondences equal, line, not_finite = good.subset({0, 1, 2, 3}), far;
  for (int i = 0; i < 20; ++i) {
    equal.add({100, 100}, {120, 100});
    line.add({static_cast<float>(i * 10), 50}, {static_cast<float>(i * 11), 60});
    not_finite.add({nan, 1}, {2, 3});
    far.add({1e30F, -1e30F}, {1e30F, 1e30F});
  }
  for (const Correspondences& few : {Correspondences(), good.subset({0, 1, 2, 3}), not_finite}) {
    EXPECT_EQ(estimatePose(few, truth).model, PoseModel::kNone);
  }
  EXPECT_FALSE(estimateHomography(Correspondences()));
  EXPECT_FALSE(estimateHomography(good.subset({0, 1, 2})));
  EXPECT_TRUE(estimateHomography(not_finite));
  const cv::Matx33d models[] = {cv::Matx33d::zeros(), cv::Matx33d::eye(), cv::Matx33d::all(std::nan("")),
                                cv::Matx33d(1, 0, 0, 0, 0, 0, 0, 0, 0)};
  for (const Correspondences& matches : {equal, line, far, good}) {
    EXPECT_NO_THROW(estimatePose(matches, truth));
    EXPECT_NO_THROW(estimateHomography(matches));
    for (const cv::Matx33d& model : models) {
      const PoseEstimate estimate = estimatePose(matches, truth, model);
      EXPECT_TRUE(std::isfinite(cv::norm(estimate.rotation) + cv::norm(estimate.translation)));
    }
  }
}

TEST(PoseEstimator, FiveMatchesSuffice) {
  const RelativePose truth = example();
  const Correspondences five = matchesOf(truth, Scene::kDeep, 5, 0, 0);
  const PoseEstimate estimate = estimatePose(five, truth);
  EXPECT_EQ(estimate.model, PoseModel::kEssential);
  EXPECT_EQ(estimate.n_inliers, 5u);
}

TEST(PoseEstimator, HomographyAmongOutliers) {
  const RelativePose truth = example();
  const Correspondences matches = matchesOf(truth, Scene::kPlane, 200, 200, 0.5);
  const std::optional<HomographyEstimate> estimate = estimateHomography(matches);
  ASSERT_TRUE(estimate);
  EXPECT_GE(estimate->n_inliers, 195u);
  EXPECT_LT(cornerError(estimate->homography, planeHomography(truth), matches.left_size), 1);
}

TEST(PoseEstimator, TextsOfTheModels) {
  for (const PoseModel model : {PoseModel::kNone, PoseModel::kEssential, PoseModel::kHomography}) {
    EXPECT_EQ(poseModelFromString(toString(model)), model);
  }
  EXPECT_TRUE(contains(errorOf([] { poseModelFromString("guess"); }), "none, essential, homography"));
}

}  // namespace
}  // namespace corrsel::core
