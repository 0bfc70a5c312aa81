#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "feature_checks.h"
#include "features/parts/image_pyramid.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class ImagePyramidTest : public ::testing::Test {
  LevelGuard guard_;
};

cv::Mat matOf(const PyramidLevel& level) {
  return cv::Mat(level.height, level.width, CV_8U, const_cast<std::uint8_t*>(level.pixels),
                 std::size_t(level.stride))
      .clone();
}

cv::Mat reduced(const cv::Mat& image, double factor, int levels) {
  ImagePyramid pyramid;
  pyramid.start(image, factor, levels, false);
  for (int level = 1; level < levels; ++level) pyramid.reduce(level, Workspace::ofThread());
  return matOf(pyramid.level(levels - 1));
}

cv::Mat blurred(const cv::Mat& image) {
  ImagePyramid pyramid;
  pyramid.start(image, 1.2, 1, true);
  pyramid.blur(0, cv::Rect(3, 3, image.cols - 6, image.rows - 6), Workspace::ofThread());
  constexpr int kReach = ImagePyramid::kBlurReach;
  return matOf(pyramid.blurred(0))(
      cv::Rect(kReach, kReach, image.cols - 2 * kReach, image.rows - 2 * kReach));
}

TEST_F(ImagePyramidTest, ReductionIsThatOfOpenCvWithinRounding) {
  for (const double factor : {1.05, 1.2, 1.5, 1.99, 2.0, 2.7, 3.0}) {
    for (const cv::Size size : {cv::Size(401, 300), cv::Size(77, 51)}) {
      const cv::Mat image = shapes(1, size);
      const cv::Mat found = reduced(image, factor, 2);
      cv::Mat expected;
      cv::resize(image, expected, found.size(), 0, 0, cv::INTER_LINEAR);
      EXPECT_EQ(found.cols, int(std::lround(size.width / factor)));
      EXPECT_LE(cv::norm(found, expected, cv::NORM_INF), 2) << factor;
      EXPECT_LE(cv::norm(found, expected, cv::NORM_L1) / double(found.total()), 0.3) << factor;
    }
  }
}

TEST_F(ImagePyramidTest, ConstantImagesStayConstant) {
  for (const int grey : {0, 1, 127, 254, 255}) {
    const cv::Mat image(120, 160, CV_8U, cv::Scalar(grey));
    EXPECT_EQ(cv::norm(reduced(image, 1.2, 6), cv::Mat(48, 64, CV_8U, cv::Scalar(grey)), cv::NORM_INF), 0);
    const cv::Mat soft = blurred(image);
    EXPECT_EQ(cv::norm(soft, cv::Mat(soft.size(), CV_8U, cv::Scalar(grey)), cv::NORM_INF), 0) << grey;
  }
}

TEST_F(ImagePyramidTest, BlurIsAGaussian) {
  const cv::Mat image = shapes(1, {301, 200});
  cv::Mat exact;
  image.convertTo(exact, CV_32F);
  cv::GaussianBlur(exact, exact, {7, 7}, 2);
  cv::Mat found;
  blurred(image).convertTo(found, CV_32F);
  const cv::Mat expected = exact(cv::Rect(3, 3, found.cols, found.rows));
  // Half a grey level of rounding, and weights of 7 bits.
  EXPECT_LE(cv::norm(found, expected, cv::NORM_INF), 1.6);
  EXPECT_NEAR(cv::mean(found)[0], cv::mean(expected)[0], 0.05);
}

TEST_F(ImagePyramidTest, IsTheSameAtEveryLevelOfTheKernels) {
  for (const double factor : {1.2, 1.7, 2.6}) {
    const cv::Mat image = shapes(1, {333, 250});
    setKernelLevel(KernelLevel::kPlain);
    const cv::Mat small = reduced(image, factor, 3), soft = blurred(image);
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      EXPECT_EQ(cv::norm(reduced(image, factor, 3), small, cv::NORM_INF), 0) << toString(level);
      EXPECT_EQ(cv::norm(blurred(image), soft, cv::NORM_INF), 0) << toString(level);
    }
  }
}

TEST_F(ImagePyramidTest, ImagesOfOtherSizesLeaveNothingBehind) {
  ImagePyramid pyramid;
  for (const cv::Size size : {cv::Size(200, 150), cv::Size(90, 300), cv::Size(201, 150)}) {
    const cv::Mat image = shapes(1, size);
    pyramid.start(image, 1.3, 4, false);
    for (int level = 1; level < 4; ++level) pyramid.reduce(level, Workspace::ofThread());
    EXPECT_EQ(cv::norm(matOf(pyramid.level(3)), reduced(image, 1.3, 4), cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(matOf(pyramid.level(0)), image, cv::NORM_INF), 0);
  }
}

TEST_F(ImagePyramidTest, PlacesGoToTheImageAndBack) {
  ImagePyramid pyramid;
  pyramid.start(cv::Mat(413, 640, CV_8U, cv::Scalar(0)), 1.2, 8, false);
  for (int number = 0; number < 8; ++number) {
    const PyramidLevel& level = pyramid.level(number);
    for (const cv::Point at :
         {cv::Point(0, 0), cv::Point(17, 40), cv::Point(level.width - 1, level.height - 1)}) {
      const cv::Point2f image = level.toImage(at.x, at.y);
      EXPECT_EQ(level.fromImage(image), at);
      EXPECT_EQ(level.fromImage(image + cv::Point2f(0.4F, -0.4F) * float(level.scale)), at);
    }
    // The corners of the image are the corners of the level.
    EXPECT_NEAR(level.toImage(-1, -1).x + level.toImage(level.width, 0).x, 639, 1e-3);
  }
}

TEST(LevelShares, AreAGeometricSeries) {
  const std::vector<int> shares = levelShares(1000, 1.2, 8);
  ASSERT_EQ(shares.size(), 8u);
  int sum = 0;
  for (const int share : shares) sum += share;
  EXPECT_EQ(sum, 1000);
  for (std::size_t i = 1; i < shares.size(); ++i) EXPECT_NEAR(shares[i] * 1.2, shares[i - 1], 2);
  EXPECT_EQ(levelShares(3, 1.2, 1), std::vector<int>{3});
}

TEST(UsableLevels, HoldAPatch) {
  EXPECT_EQ(usableLevels({640, 480}, 1.2, 8, 31), 8);
  EXPECT_EQ(usableLevels({640, 70}, 1.2, 8, 31), 5);  // 70 / 1.2^4 = 33.8
  EXPECT_EQ(usableLevels({10, 10}, 1.2, 8, 31), 1);
}

}  // namespace
}  // namespace corrsel::core
