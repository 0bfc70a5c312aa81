#include <gtest/gtest.h>

#include <limits>

#include "corrsel/evaluation/errors.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Correspondences matches(const std::vector<cv::Vec4f>& rows) {
  Correspondences m;
  for (const cv::Vec4f& r : rows) m.add({r[0], r[1]}, {r[2], r[3]});
  return m;
}

TEST(Errors, KindsHaveTexts) {
  const std::vector<std::string> texts = {"none",      "homography", "fundamental", "labels",
                                          "disparity", "essential",  "rotation"};
  for (std::size_t i = 0; i < texts.size(); ++i) EXPECT_EQ(toString(static_cast<TruthKind>(i)), texts[i]);
  for (const std::string& text : texts) EXPECT_EQ(toString(truthKindFromString(text)), text);
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] { toString(static_cast<TruthKind>(7)); }),
                       {"ground truth", "7"}));
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] { truthKindFromString("plane"); }),
                       {"'plane'", "homography, fundamental"}));
}

TEST(Errors, UnknownWithoutTruth) {
  const std::vector<double> errors = groundTruthErrors({}, matches({{1, 2, 3, 4}, {5, 6, 7, 8}}));
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_TRUE(std::isnan(errors[0]) && std::isnan(errors[1]));
  EXPECT_TRUE(groundTruthErrors({}, {}).empty());
}

TEST(Errors, HomographyTransfersForward) {
  GroundTruth truth;
  truth.kind = TruthKind::kHomography;
  truth.matrix = cv::Matx33d(2, 0, 1, 0, 3, -1, 0, 0.5, 1);
  // (4, 2) goes to (4.5, 2.5); rows 2 and 3 lie at and behind the line w = 0.
  const std::vector<double> errors = groundTruthErrors(
      truth, matches({{4, 2, 4.5f, 2.5f}, {4, 2, 7.5f, -1.5f}, {4, -2, 0, 0}, {4, -3, 0, 0}}));
  EXPECT_DOUBLE_EQ(errors[0], 0);
  EXPECT_DOUBLE_EQ(errors[1], 5);
  EXPECT_EQ(errors[2], INFINITY);
  EXPECT_EQ(errors[3], INFINITY);
}

TEST(Errors, FundamentalMeasuresInTheRightImage) {
  GroundTruth truth;
  truth.kind = TruthKind::kFundamental;
  truth.matrix = cv::Matx33d(1, 2, 2, 1, 3, 2, 4, 3, 2);
  // F (3, 1, 1) = (7, 8, 17).
  const std::vector<double> errors = groundTruthErrors(truth, matches({{3, 1, 1, 2}, {3, 1, 1, -3}}));
  EXPECT_DOUBLE_EQ(errors[0], 40 / std::sqrt(113.0));
  EXPECT_DOUBLE_EQ(errors[1], 0);
}

Camera fisheye() {
  Camera camera;
  camera.model = Camera::Model::kFisheye;
  camera.matrix = {200, 0, 320, 0, 200, 240, 0, 0, 1};
  return camera;
}

TEST(Errors, EssentialMatrixMeasuresAcrossTheEpipolarCurve) {
  GroundTruth truth;
  truth.kind = TruthKind::kEssential;
  truth.matrix = {0, 0, 0, 0, 0, -1, 0, 1, 0};  // t along x, no rotation
  Correspondences m;
  m.left_camera = m.right_camera = fisheye();
  const cv::Vec3d points[] = {{0, 0, 5}, {2, -1, 3}, {4, 3, 0.5}, {-3, 1, -1}};
  for (const cv::Vec3d& point : points) {
    cv::Point2d left, right, further;
    ASSERT_TRUE(project(fisheye(), point, left) && project(fisheye(), point + cv::Vec3d(1, 0, 0), right));
    ASSERT_TRUE(project(fisheye(), point + cv::Vec3d(1.001, 0, 0), further));
    m.add(left, right);
    // One pixel across the curve; the error is shared by both images.
    const cv::Point2d along = (further - right) / cv::norm(further - right);
    m.add(left, right + cv::Point2d(-along.y, along.x));
  }
  const std::vector<double> errors = groundTruthErrors(truth, m);
  for (std::size_t i = 0; i < errors.size(); i += 2) {
    EXPECT_NEAR(errors[i], 0, 1e-3) << i;
    EXPECT_GT(errors[i + 1], 0.5) << i;
    EXPECT_LT(errors[i + 1], 1) << i;
  }
  // A point without a ray: beyond 180 degrees from the axis.
  m.add({5000, 240}, {320, 240});
  m.add({kNaN, 240}, {320, 240});
  EXPECT_EQ(groundTruthErrors(truth, m)[8], INFINITY);
  EXPECT_EQ(groundTruthErrors(truth, m)[9], INFINITY);
  m.right_camera.reset();
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { groundTruthErrors(truth, m); }),
                       {"essential", "both cameras"}));
}

TEST(Errors, OfPinholesAreSampsonDistances) {
  Camera camera;
  camera.matrix = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  RelativePose pose;
  pose.left_camera = pose.right_camera = camera.matrix;
  pose.rotation = {0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8};
  pose.translation = {1, 0.5, 0.2};
  GroundTruth truth;
  truth.kind = TruthKind::kEssential;
  truth.matrix = cv::Matx33d(0, -0.2, 0.5, 0.2, 0, -1, -0.5, 1, 0) * pose.rotation;
  Correspondences m;
  m.left_camera = m.right_camera = camera;
  for (const cv::Vec3d& point : {cv::Vec3d(-1, -0.5, 4), cv::Vec3d(1.2, 0.4, 5), cv::Vec3d(0.3, -1.1, 6)}) {
    cv::Point2d left, right;
    ASSERT_TRUE(project(camera, point, left));
    ASSERT_TRUE(project(camera, pose.rotation * point + pose.translation, right));
    m.add(left + cv::Point2d(0.3, 0.5), right + cv::Point2d(-0.2, 0.4));
  }
  const std::vector<double> errors = groundTruthErrors(truth, m);
  const cv::Matx33d f = pose.fundamental();
  for (std::size_t i = 0; i < m.size(); ++i) {
    const cv::Vec3d x(m.left_x[i], m.left_y[i], 1), y(m.right_x[i], m.right_y[i], 1);
    const cv::Vec3d a = f * x, b = f.t() * y;
    const double sampson =
        std::abs(y.dot(a)) / std::sqrt(a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1]);
    EXPECT_GT(sampson, 0.01);
    EXPECT_NEAR(errors[i], sampson, 2e-3 * sampson);  // equal to first order
  }
}

TEST(Errors, RotationMeasuresTheAngleInPixels) {
  GroundTruth truth;
  truth.kind = TruthKind::kRotation;
  truth.matrix = {0, 0, 1, 0, 1, 0, -1, 0, 0};  // a quarter turn
  Camera panorama;
  panorama.model = Camera::Model::kEquirectangular;
  panorama.size = {1000, 500};
  // The right point of the second match lies beyond the edge of the panorama from where it should be.
  Correspondences m = matches({{300, 249.5f, 553, 249.5f}, {748.5f, 249.5f, 0.5f, 249.5f}, {1, 1, kNaN, 1}});
  m.left_camera = m.right_camera = panorama;
  const std::vector<double> errors = groundTruthErrors(truth, m);
  EXPECT_NEAR(errors[0], 3, 1e-3);
  EXPECT_NEAR(errors[1], 2, 1e-3);
  EXPECT_EQ(errors[2], INFINITY);
}

TEST(Errors, LabelsAreRightOrWrong) {
  GroundTruth truth;
  truth.kind = TruthKind::kLabels;
  truth.labels = {0, 1, 7};
  const Correspondences m = matches({{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}});
  EXPECT_EQ(groundTruthErrors(truth, m), (std::vector<double>{INFINITY, 0, 0}));
  truth.labels = {0, 1};
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { groundTruthErrors(truth, m); }),
                       {"2 labels", "3 matches"}));
  truth.labels.clear();
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { groundTruthErrors(truth, m); }),
                       {"0 labels", "3 matches"}));
}

TEST(Errors, DisparityPredictsTheRightPoint) {
  GroundTruth truth;
  truth.kind = TruthKind::kDisparity;
  truth.disparity = (cv::Mat_<float>(2, 3) << 1, 2, 3, 10, kNaN, 30);
  const std::vector<double> errors =
      groundTruthErrors(truth, matches({{2, 0, -1, 0},              // 2 - 3 = -1: right
                                        {2, 0, 2, 4},               // 3 px right, 4 px down of it
                                        {0.4f, 0.6f, -9.6f, 0.6f},  // nearest pixel: column 0, row 1
                                        {1, 1, 0, 0},               // no disparity
                                        {2, 1, -28, 1},             // the last pixel still counts
                                        {2.1f, 1, 0, 1},            // beyond the last column
                                        {2, 1.1f, 0, 1},            // beyond the last row
                                        {-0.1f, 0, 0, 0},
                                        {0, -0.1f, 0, 0},
                                        {kNaN, 0, 0, 0}}));
  EXPECT_DOUBLE_EQ(errors[0], 0);
  EXPECT_DOUBLE_EQ(errors[1], 5);
  EXPECT_NEAR(errors[2], 0, 1e-5);
  EXPECT_TRUE(std::isnan(errors[3]));
  EXPECT_DOUBLE_EQ(errors[4], 0);
  for (std::size_t i = 5; i < 9; ++i) EXPECT_TRUE(std::isnan(errors[i])) << i;
  EXPECT_EQ(errors[9], std::numeric_limits<double>::infinity());
}

TEST(Errors, CoordinatesThatAreNotFiniteAreWrongWhateverTheSide) {
  GroundTruth truth;
  truth.kind = TruthKind::kHomography;
  for (const double error : groundTruthErrors(truth, matches({{kNaN, 0, 0, 0}, {0, 0, 0, kNaN}}))) {
    EXPECT_EQ(error, std::numeric_limits<double>::infinity());
  }
}

TEST(Errors, SignOfAHomographyDoesNotMatter) {
  GroundTruth truth;
  truth.kind = TruthKind::kHomography;
  truth.matrix = cv::Matx33d(1, 0, 3, 0, 1, 4, 0, 0, 1) * -0.5;
  Correspondences m = matches({{10, 20, 10, 20}});
  EXPECT_DOUBLE_EQ(groundTruthErrors(truth, m)[0], 5);
  m.left_size = {100, 80};
  EXPECT_DOUBLE_EQ(groundTruthErrors(truth, m)[0], 5);
}

}  // namespace
}  // namespace corrsel::core
