#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "corrsel/features/image_faults.h"
#include "corrsel/features/image_quality_meter.h"
#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

constexpr int kWidth = 640, kHeight = 480, kFiner = 2;

struct Look {
  double blur = 0.7;      ///< px
  double contrast = 120;  ///< grey levels
  double noise = 0;       ///< grey levels
  int type = CV_8UC1;
};

/// Turned rectangles whose edges have a known width: they are drawn larger, blurred, and reduced,
/// which blurs by the area of a pixel.
cv::Mat scene(const Look& look, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat fine(kFiner * kHeight, kFiner * kWidth, CV_8U, cv::Scalar(0));
  for (int i = 0; i < 40; ++i) {
    const auto x = static_cast<float>(random.uniform() * fine.cols);
    const auto y = static_cast<float>(random.uniform() * fine.rows);
    const auto width = static_cast<float>(kFiner * random.uniform(40, 125));
    const auto height = static_cast<float>(kFiner * random.uniform(40, 125));
    cv::Point2f corners[4];
    cv::RotatedRect({x, y}, {width, height}, static_cast<float>(90 * random.uniform())).points(corners);
    const std::vector<cv::Point> polygon(corners, corners + 4);
    cv::fillConvexPoly(fine, polygon, cv::Scalar(i % 2 == 0 ? 255 : 0));
  }
  cv::Mat image;
  fine.convertTo(image, CV_32F, look.contrast / 255, 128 - look.contrast / 2);
  const double by_area = (kFiner * kFiner - 1) / 12.0;
  cv::GaussianBlur(image, image, {0, 0}, std::sqrt(std::pow(kFiner * look.blur, 2) - by_area));
  cv::resize(image, image, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  if (look.noise > 0) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        image.at<float>(y, x) += static_cast<float>(look.noise * random.normal());
    }
  }
  const bool deep = CV_MAT_DEPTH(look.type) == CV_16U;
  image.convertTo(image, CV_MAT_DEPTH(look.type), deep ? 257 : 1);
  if (CV_MAT_CN(look.type) == 3) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  return image;
}

ImageQuality qualityOf(const cv::Mat& image) { return ImageQualityMeter().measure(image, 0); }

TEST(ImageQuality, BlurIsTheWidthOfTheEdges) {
  for (const double blur : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0}) {
    for (const double contrast : {20.0, 60.0, 200.0}) {
      Look look;
      look.blur = blur;
      look.contrast = contrast;
      EXPECT_NEAR(qualityOf(scene(look)).blur, blur, 0.15 * blur) << contrast;
    }
  }
}

TEST(ImageQuality, BlurHardlyDependsOnNoise) {
  for (const double blur : {0.5, 1.0, 2.0, 3.0}) {
    for (const double noise : {2.0, 5.0, 10.0}) {
      Look look;
      look.blur = blur;
      look.contrast = 160;
      look.noise = noise;
      EXPECT_NEAR(qualityOf(scene(look)).blur, blur, 0.15 * blur) << noise;
    }
  }
}

TEST(ImageQuality, MotionInOneDirectionIsBlur) {
  const cv::Mat sharp = scene({});
  for (const cv::Size& path : {cv::Size(11, 1), cv::Size(1, 11)}) {
    cv::Mat moved;
    cv::blur(sharp, moved, path);
    EXPECT_GT(qualityOf(moved).blur, 2.0) << path;
  }
}

TEST(ImageQuality, NoiseIsThatOfAPixel) {
  for (const double noise : {1.0, 2.0, 5.0, 10.0, 20.0}) {
    Look look;
    look.noise = noise;
    EXPECT_NEAR(qualityOf(scene(look)).noise, noise, 0.15 * noise);
  }
  EXPECT_LT(qualityOf(scene({})).noise, 0.3);
}

TEST(ImageQuality, SharesAreCounted) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
    Look look;
    look.type = type;
    cv::Mat image = scene(look);
    const double scale = image.depth() == CV_16U ? 257 : 1;
    image(cv::Rect(0, 0, kWidth, 48)).setTo(cv::Scalar::all(7 * scale));
    image(cv::Rect(100, 240, 160, 240)).setTo(cv::Scalar::all(255 * scale));
    const ImageQuality quality = qualityOf(image);
    EXPECT_DOUBLE_EQ(quality.black, 0.1) << type;
    EXPECT_DOUBLE_EQ(quality.saturated, 0.125) << type;
  }
}

TEST(ImageQuality, DoesNotDependOnTheType) {
  const ImageQuality grey = qualityOf(scene({}));
  for (const int type : {CV_8UC3, CV_16UC1}) {
    Look look;
    look.type = type;
    const ImageQuality quality = qualityOf(scene(look));
    EXPECT_NEAR(quality.blur, grey.blur, 0.01) << type;
    EXPECT_NEAR(quality.noise, grey.noise, 0.05) << type;
  }
  const cv::Mat part = scene({})(cv::Rect(3, 5, 601, 433));
  EXPECT_EQ(qualityOf(part).blur, qualityOf(part.clone()).blur);
}

TEST(ImageQuality, SmallAndBlankImages) {
  const ImageQuality blank = qualityOf(cv::Mat(200, 300, CV_8U, cv::Scalar(90)));
  EXPECT_TRUE(std::isnan(blank.blur) && std::isnan(blank.relative_blur));
  EXPECT_EQ(blank.noise, 0);
  EXPECT_EQ(blank.black, 0);
  EXPECT_TRUE(std::isnan(qualityOf(cv::Mat(200, 300, CV_8U, cv::Scalar(0))).noise)) << "clipped";
  for (int side = 1; side < 70; ++side) {
    const cv::Mat image = scene({})(cv::Rect(10, 20, side, 71 - side));
    const ImageQuality quality = qualityOf(image);
    EXPECT_EQ(quality.black, 0) << side;
    EXPECT_TRUE((side >= 32 && side <= 39) || std::isnan(quality.noise)) << side;
  }
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([] { qualityOf({}); }), "empty"));
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([] { qualityOf(cv::Mat(9, 9, CV_32F)); }), "32FC1"));
}

TEST(ImageQuality, BlurIsComparedWithTheSharpImagesOfTheLastSeconds) {
  Look look;
  const cv::Mat sharp = scene(look);
  look.blur = 2.1;
  const cv::Mat blurred = scene(look);
  ImageQualityMeter meter;
  for (int i = 0; i < 60; ++i) {
    EXPECT_NEAR(meter.measure(sharp, 10 + 0.05 * i).relative_blur, 1, 0.01) << i;
  }
  EXPECT_NEAR(meter.measure(blurred, 13.1).relative_blur, 3, 0.4);
  EXPECT_NEAR(meter.measure(sharp, 13.2).relative_blur, 1, 0.01);
  for (int i = 0; i < 120; ++i) meter.measure(blurred, 13.3 + 0.05 * i);
  EXPECT_NEAR(meter.measure(blurred, 19.4).relative_blur, 1, 0.01) << "the sharp ones are forgotten";
  meter.measure(sharp, 19.5);
  EXPECT_NEAR(meter.measure(blurred, 2).relative_blur, 1, 0.01) << "another time";
}

TEST(ImageQuality, TextureIsTheShareOfCellsWithFeatures) {
  Features features;
  EXPECT_TRUE(std::isnan(textureOf(features)));
  features.image_size = {80, 160};
  EXPECT_EQ(textureOf(features), 0);
  for (const cv::Point2f& point : {cv::Point2f(-0.5F, -0.5F), {9.4F, 19.4F}, {9.6F, 10}, {79.5F, 159.5F}}) {
    features.keypoints.emplace_back(point, 5.F);
  }
  EXPECT_DOUBLE_EQ(textureOf(features), 3 / 64.0);
}

ImageQuality goodQuality() {
  ImageQuality quality;
  quality.black = quality.saturated = 0.02;
  quality.blur = 0.6;
  quality.relative_blur = 1;
  quality.noise = 2;
  quality.texture = 50 / 64.0;
  return quality;
}

TEST(ImageFaults, AreNamedWithTheirNumbers) {
  EXPECT_EQ(faultsOf(goodQuality(), "image"), "");
  EXPECT_EQ(faultsOf(ImageQuality(), "image"), "") << "nothing is known";
  ImageQuality quality = goodQuality();
  quality.black = 0.93;
  quality.texture = 0;
  EXPECT_EQ(faultsOf(quality, "image"), "the image is dark: 93 % of the pixels are black");
  quality = goodQuality();
  quality.saturated = 0.6;
  EXPECT_EQ(faultsOf(quality, "left image"),
            "the left image is overexposed: 60 % of the pixels are saturated");
  quality = goodQuality();
  quality.blur = 3;
  quality.relative_blur = 4;
  EXPECT_EQ(faultsOf(quality, "image", 80 * M_PI / 180),
            "the image is blurred: edges 3.0 px wide, 4.0 times those of the sharp images before; turn of 80 "
            "deg/s");
  quality.relative_blur = 1;
  EXPECT_EQ(faultsOf(quality, "image", 0.01), "the image is blurred: edges 3.0 px wide");
  quality.noise = 18;
  EXPECT_EQ(faultsOf(quality, "image"),
            "the image is blurred: edges 3.0 px wide, and is noisy: standard deviation 18 of 255");
  quality = goodQuality();
  quality.texture = 3 / 64.0;
  EXPECT_EQ(faultsOf(quality, "image"), "the image has little texture: features in 3 of 64 cells");
  EXPECT_EQ(
      faultsOf(quality, quality, NAN),
      "the left image has little texture: features in 3 of 64 cells; the right image has little texture: "
      "features in 3 of 64 cells");
}

TEST(ImageFaults, NumbersAreText) {
  EXPECT_EQ(toText(goodQuality()),
            "black 2 %, saturated 2 %, blur 0.6 px, 1.0 times that of sharp images, noise 2.0 of 255, "
            "features in 50 "
            "of 64 cells");
  EXPECT_EQ(toText(ImageQuality()), "not measured");
}

TEST(ImageFaults, ATurnHasARate) {
  const double angle = 0.1;
  const cv::Matx33d rotation(std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0,
                             1);
  EXPECT_NEAR(turnRate(rotation, 0.05), 2, 1e-9);
  EXPECT_NEAR(turnRate(rotation, -0.05), 2, 1e-9);
  EXPECT_EQ(turnRate(cv::Matx33d::eye(), 0.05), 0);
  EXPECT_TRUE(std::isnan(turnRate(rotation, 0)));
}

}  // namespace
}  // namespace corrsel::core
