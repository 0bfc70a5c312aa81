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
  const std::vector<std::string> texts = {"none", "homography", "fundamental", "labels", "disparity"};
  for (std::size_t i = 0; i < texts.size(); ++i) EXPECT_EQ(toString(static_cast<TruthKind>(i)), texts[i]);
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] { toString(static_cast<TruthKind>(5)); }),
                       {"ground truth", "5"}));
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
