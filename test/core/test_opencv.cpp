#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "corrsel/opencv.h"
#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::opencv {
namespace {

using core::testing::errorOf;
using core::testing::mentions;

constexpr double kNoise = 0.3;  // px
const cv::Matx33d kCamera = {700, 0, 320, 0, 700, 240, 0, 0, 1};

struct Points {
  std::vector<cv::Point2f> left, right;
  std::vector<std::uint8_t> right_matches;  ///< truth
};

cv::Point2f imageOf(const cv::Vec3d& point, core::Random& random) {
  const cv::Vec3d p = kCamera * point;
  const double x = p[0] / p[2] + random.uniform(-kNoise, kNoise);
  const double y = p[1] / p[2] + random.uniform(-kNoise, kNoise);
  return {static_cast<float>(x), static_cast<float>(y)};
}

const cv::Matx33d kRotation = [] {
  cv::Matx33d rotation;
  cv::Rodrigues(cv::Vec3d(0.05, -0.15, 0.02), rotation);
  return rotation;
}();
const cv::Vec3d kTranslation(-1, 0.1, 0.2);

/// Images of random points, at depths from 4 to `deepest`, and a share of outliers.
Points pairOf(int seed, double deepest, int inliers = 200, int outliers = 150) {
  core::Random random(static_cast<std::uint64_t>(seed));
  Points points;
  for (int i = 0; i < inliers + outliers; ++i) {
    const double depth = random.uniform(4, deepest);
    const double x = random.uniform(-0.4, 0.4), y = random.uniform(-0.3, 0.3);
    const cv::Vec3d point(x * depth, y * depth, depth);
    points.left.push_back(imageOf(point, random));
    if (i < inliers) {
      points.right.push_back(imageOf(kRotation * point + kTranslation, random));
    } else {
      const double u = random.uniform(0, 640), v = random.uniform(0, 480);
      points.right.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
    points.right_matches.push_back(i < inliers ? 1 : 0);
  }
  return points;
}

Points plane(int seed) { return pairOf(seed, 4); }
Points depth(int seed) { return pairOf(seed, 12); }

/// True matches among those of the mask.
int rightOnes(const cv::Mat& mask, const Points& points) {
  int count = 0;
  for (int i = 0; i < mask.rows; ++i)
    count += mask.at<std::uint8_t>(i) & points.right_matches[static_cast<std::size_t>(i)];
  return count;
}

void expectMask(const cv::Mat& mask, const Points& points) {
  ASSERT_EQ(mask.size(), cv::Size(1, static_cast<int>(points.left.size())));
  ASSERT_EQ(mask.type(), CV_8U);
}

cv::Mat essentialTruth() {
  const cv::Vec3d t = kTranslation / cv::norm(kTranslation);
  const cv::Matx33d cross = {0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0};
  return cv::Mat(cross * kRotation / std::sqrt(2.0), true);
}

double differenceUpToSign(const cv::Mat& a, const cv::Mat& b) {
  return std::min(cv::norm(a, b), cv::norm(a, -b));
}

#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 5
constexpr int kBestOfOpenCv = cv::USAC_MAGSAC;
#else
constexpr int kBestOfOpenCv = cv::RANSAC;
#endif
constexpr int kPairs = 50;

const int kNumbers[] = {cv::LMEDS, cv::RANSAC, cv::RHO};

TEST(OpenCv, HomographiesAreThoseOfOpenCv) {
  for (int seed = 0; seed < kPairs; ++seed) {
    const Points points = plane(seed);
    cv::Mat theirs_mask;
    const cv::Mat theirs = cv::findHomography(points.left, points.right, kBestOfOpenCv, 3, theirs_mask);
    for (const Method& method : {Method(cv::RANSAC), Method(cv::RHO), Method(cv::LMEDS), Method("auto")}) {
      cv::Mat mask;
      const cv::Mat ours = opencv::findHomography(points.left, points.right, method, 3, mask);
      ASSERT_EQ(ours.size(), cv::Size(3, 3)) << method.selector();
      EXPECT_EQ(ours.type(), CV_64F);
      EXPECT_EQ(ours.at<double>(2, 2), 1);
      expectMask(mask, points);
      EXPECT_GE(rightOnes(mask, points), 0.98 * rightOnes(theirs_mask, points)) << method.selector();
      EXPECT_LE(cv::countNonZero(mask) - rightOnes(mask, points), 5) << method.selector();
      std::vector<cv::Point2f> corners = {{0, 0}, {640, 0}, {640, 480}, {0, 480}}, our_corners, their_corners;
      cv::perspectiveTransform(corners, our_corners, ours);
      cv::perspectiveTransform(corners, their_corners, theirs);
      EXPECT_LT(cv::norm(our_corners, their_corners, cv::NORM_INF), 2) << method.selector();
    }
  }
}

TEST(OpenCv, FundamentalMatricesKeepTheInliersOfOpenCv) {
  for (int seed = 0; seed < kPairs; ++seed) {
    const Points points = depth(seed);
    cv::Mat theirs_mask, mask;
    cv::findFundamentalMat(points.left, points.right, kBestOfOpenCv, 1.5, 0.999, theirs_mask);
    const cv::Mat ours =
        opencv::findFundamentalMat(points.left, points.right, cv::FM_RANSAC, 1.5, 0.999, mask);
    ASSERT_EQ(ours.size(), cv::Size(3, 3));
    expectMask(mask, points);
    EXPECT_GE(rightOnes(mask, points), 0.98 * rightOnes(theirs_mask, points));
    EXPECT_NEAR(ours.at<double>(2, 2), 1, 1e-12);
    EXPECT_LT(std::abs(cv::determinant(ours)), 1e-9);
    // The fundamental matrix of the truth.
    const cv::Mat truth = cv::Mat(kCamera.inv().t()) * essentialTruth() * cv::Mat(kCamera.inv());
    EXPECT_LT(differenceUpToSign(ours / cv::norm(ours), truth / cv::norm(truth)), 0.05);
  }
}

TEST(OpenCv, EssentialMatricesGiveTheirPose) {
  for (int seed = 0; seed < 10; ++seed) {
    const Points points = depth(seed);
    for (const Method& method : {Method(cv::RANSAC), Method("pose"), Method("usac")}) {
      cv::Mat mask;
      const cv::Mat ours =
          opencv::findEssentialMat(points.left, points.right, kCamera, method, 0.999, 1.0, mask);
      ASSERT_EQ(ours.size(), cv::Size(3, 3)) << method.selector();
      EXPECT_NEAR(cv::norm(ours), 1, 1e-12);
      expectMask(mask, points);
      EXPECT_GE(rightOnes(mask, points), 190) << method.selector();
      EXPECT_LT(differenceUpToSign(ours, essentialTruth()), 0.02) << method.selector();
      cv::Mat rotation, translation;
      EXPECT_GE(cv::recoverPose(ours, points.left, points.right, kCamera, rotation, translation, mask), 180);
      EXPECT_LT(cv::norm(rotation, cv::Mat(kRotation)), 0.01);
    }
  }
}

TEST(OpenCv, EveryListOfArgumentsOfEssentialMatrices) {
  const Points points = depth(1);
  cv::Mat mask[4];
  const cv::Mat plain =
      opencv::findEssentialMat(points.left, points.right, kCamera, "pose", 0.999, 1.0, mask[0]);
  const cv::Mat focal =
      opencv::findEssentialMat(points.left, points.right, 700, {320, 240}, "pose", 0.999, 1.0, 1000, mask[1]);
  const cv::Mat older =
      opencv::findEssentialMat(points.left, points.right, 700, {320, 240}, "pose", 0.999, 1.0, mask[2]);
  const cv::Mat two = opencv::findEssentialMat(points.left, points.right, kCamera, cv::noArray(), kCamera,
                                               std::vector<double>(5), "pose", 0.999, 1.0, mask[3]);
  for (const cv::Mat& other : {focal, older, two}) EXPECT_EQ(cv::norm(plain, other, cv::NORM_INF), 0);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(cv::norm(mask[0], mask[i], cv::NORM_INF), 0);
  // Normalised points, whose threshold is in units of the focal length.
  std::vector<cv::Point2f> left, right;
  cv::undistortPoints(points.left, left, kCamera, cv::noArray());
  cv::undistortPoints(points.right, right, kCamera, cv::noArray());
  cv::Mat normalised_mask;
  const cv::Mat normalised =
      opencv::findEssentialMat(left, right, 1.0, {0, 0}, "pose", 0.999, 1.0 / 700, normalised_mask);
  EXPECT_LT(differenceUpToSign(normalised, plain), 0.01);
  EXPECT_LE(cv::norm(mask[0], normalised_mask, cv::NORM_L1), 20);
}

TEST(OpenCv, EveryFormOfPointsAndMasks) {
  const Points points = plane(2);
  std::vector<std::uint8_t> mask;
  const cv::Mat expected = opencv::findHomography(points.left, points.right, cv::RANSAC, 3, mask);
  ASSERT_EQ(mask.size(), points.left.size());
  const cv::Mat rows = cv::Mat(points.left).reshape(1), other_rows = cv::Mat(points.right).reshape(1);
  ASSERT_EQ(rows.size(), cv::Size(2, static_cast<int>(points.left.size())));
  cv::Mat doubles, other_doubles, second_mask;
  rows.convertTo(doubles, CV_64F);
  other_rows.convertTo(other_doubles, CV_64F);
  const cv::Mat wide_left(1, rows.rows, CV_32FC2, rows.data),
      wide_right(1, rows.rows, CV_32FC2, other_rows.data);
  for (const auto& [left, right] : std::vector<std::pair<cv::Mat, cv::Mat>>{
           {rows, other_rows}, {doubles, other_doubles}, {wide_left, wide_right}}) {
    EXPECT_EQ(
        cv::norm(opencv::findHomography(left, right, second_mask, cv::RANSAC, 3), expected, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(second_mask, cv::Mat(mask), cv::NORM_INF), 0);
  }
  EXPECT_FALSE(opencv::findFundamentalMat(points.left, points.right, second_mask, "auto").empty());
}

TEST(OpenCv, NamesAreSelectors) {
  const Points points = plane(3);
  cv::Mat auto_mask, preset_mask, lpm_mask;
  ASSERT_FALSE(opencv::findHomography(points.left, points.right, "auto", 3, auto_mask).empty());
  ASSERT_FALSE(opencv::findHomography(points.left, points.right, "usac:h[seed=5]", 3, preset_mask).empty());
  // lpm has no model: usac fits it to what lpm kept.
  const cv::Mat fitted = opencv::findHomography(points.left, points.right, "lpm", 3, lpm_mask);
  ASSERT_FALSE(fitted.empty());
  EXPECT_GE(rightOnes(lpm_mask, points), 150);
  EXPECT_LE(cv::countNonZero(lpm_mask) - rightOnes(lpm_mask, points), 5);
}

TEST(OpenCv, OnlyALargerNumberOfIterationsCounts) {
  const Points points = plane(4);
  cv::Mat few, usual, more;
  const cv::Mat a = opencv::findHomography(points.left, points.right, cv::RANSAC, 3, few, 1);
  const cv::Mat b = opencv::findHomography(points.left, points.right, cv::RANSAC, 3, usual);
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
  EXPECT_FALSE(
      opencv::findHomography(points.left, points.right, cv::RANSAC, 3, more, 100000, 0.9999).empty());
  cv::Mat narrow, wide;
  opencv::findHomography(points.left, points.right, cv::RANSAC, 0.2, narrow);
  opencv::findHomography(points.left, points.right, cv::RANSAC, 3, wide);
  EXPECT_LT(cv::countNonZero(narrow), cv::countNonZero(wide) - 20);
}

TEST(OpenCv, DegenerateDataGiveNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<cv::Point2f> three = {{0, 0}, {5, 1}, {2, 8}}, equal(50, {3, 4}),
                                 undefined(50, {nan, nan});
  for (const auto& points : {three, equal, undefined}) {
    for (const int number : kNumbers) {
      cv::Mat mask;
      EXPECT_TRUE(opencv::findHomography(points, points, number, 3, mask).empty());
      EXPECT_EQ(mask.rows, static_cast<int>(points.size()));
      EXPECT_EQ(cv::countNonZero(mask), 0);
      EXPECT_TRUE(opencv::findFundamentalMat(points, points, number).empty());
      EXPECT_TRUE(opencv::findEssentialMat(points, points, kCamera, number).empty());
    }
  }
  EXPECT_TRUE(opencv::findHomography(std::vector<cv::Point2f>(), std::vector<cv::Point2f>()).empty());
  // Only turned: no essential matrix, but no exception either.
  const Points turned = [] {
    Points points = plane(5);
    core::Random random(7);
    for (std::size_t i = 0; i < points.left.size(); ++i) {
      const cv::Vec3d ray = kCamera.inv() * cv::Vec3d(points.left[i].x, points.left[i].y, 1);
      points.right[i] = imageOf(kRotation * ray, random);
    }
    return points;
  }();
  EXPECT_TRUE(opencv::findEssentialMat(turned.left, turned.right, kCamera, "pose").empty());
}

TEST(OpenCv, ChanceGivesNothing) {
  for (int seed = 0; seed < 4; ++seed) {
    const Points points = pairOf(seed, 12, 0, 60);
    for (const Method& method : {Method(cv::RANSAC), Method(cv::LMEDS), Method("auto")}) {
      cv::Mat mask;
      EXPECT_TRUE(opencv::findHomography(points.left, points.right, method, 3, mask).empty())
          << method.selector();
      EXPECT_EQ(cv::countNonZero(mask), 0);
      EXPECT_TRUE(opencv::findFundamentalMat(points.left, points.right, method, 1.5).empty())
          << method.selector();
    }
    EXPECT_TRUE(opencv::findEssentialMat(points.left, points.right, kCamera, cv::RANSAC).empty());
    EXPECT_TRUE(opencv::findEssentialMat(points.left, points.right, kCamera, "pose").empty());
  }
}

TEST(OpenCv, WrongArgumentsAreNamed) {
  const Points points = plane(6);
  const auto refusal = [](const auto& action) { return errorOf<std::invalid_argument>(action); };
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(points.left, points.right, 0); }),
                       {"method is 0", "RANSAC", "auto"}));
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(points.left, points.right, "ransak"); }),
                       {"ransak", "did you mean"}));
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(points.left, points.right, "gms"); }),
                       {"gms", "left_size"}));
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(points.left, points.right, "pose"); }),
                       {"pose", "camera"}));
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(points.left, std::vector<cv::Point2f>(3)); }),
                       {"srcPoints has 350", "dstPoints has 3"}));
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(cv::Mat::zeros(9, 4, CV_32F), points.right); }),
                       {"srcPoints has 9 x 4", "CV_32FC1"}));
  EXPECT_TRUE(mentions(refusal([&] { opencv::findHomography(points.left, points.right, "auto", 1e9); }),
                       {"threshold", "1e+09"}));
  EXPECT_TRUE(mentions(
      refusal([&] { opencv::findEssentialMat(points.left, points.right, cv::Mat::eye(2, 2, CV_64F)); }),
      {"cameraMatrix has 2 x 2"}));
}

TEST(OpenCv, GmsKeepsMatchesThatAgreeWithTheirNeighbours) {
  core::Random random(1);
  std::vector<cv::KeyPoint> left, right;
  std::vector<cv::DMatch> matches, kept;
  for (int i = 0; i < 3000; ++i) {
    const double x = random.uniform(20, 600), y = random.uniform(20, 440);
    left.emplace_back(static_cast<float>(x), static_cast<float>(y), 5.0F);
    const bool good = i % 2 == 0;
    const double u = good ? x + 15 : random.uniform(0, 639), v = good ? y - 8 : random.uniform(0, 479);
    right.emplace_back(static_cast<float>(u), static_cast<float>(v), 5.0F);
    matches.emplace_back(i, i, 0.0F);
  }
  opencv::matchGMS({640, 480}, {640, 480}, left, right, matches, kept);
  int good = 0;
  for (const cv::DMatch& match : kept) good += match.queryIdx % 2 == 0 ? 1 : 0;
  EXPECT_GE(good, 1350);
  EXPECT_GE(good, 0.95 * static_cast<double>(kept.size()));
  for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_LT(kept[i - 1].queryIdx, kept[i].queryIdx);
  // One vector for both; other options.
  const std::size_t count = kept.size();
  std::vector<cv::DMatch> both = matches;
  opencv::matchGMS({640, 480}, {640, 480}, left, right, both, both);
  EXPECT_EQ(both.size(), count);
  opencv::matchGMS({640, 480}, {640, 480}, left, right, matches, kept, true, true, 4.0);
  EXPECT_GE(kept.size(), 1350U);
  matches[0].trainIdx = 3000;
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] {
                         opencv::matchGMS({9, 9}, {9, 9}, left, right, matches, kept);
                       }),
                       {"trainIdx 3000", "3000 keypoints"}));
}

}  // namespace
}  // namespace corrsel::opencv
