#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "features/parts/grey_image.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kAnySize = 1000;  // 10^6 px

cv::Mat noise(int type, const cv::Size& size = {50, 40}) {
  cv::Mat image(size, type);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 65536);
  return image;
}

TEST(GreyImage, GreyOfEightBitsIsShared) {
  const cv::Mat image = noise(CV_8U), part = image({10, 5, 20, 30});
  GreyBuffer buffer;
  for (const cv::Mat& grey : {image, part}) {
    const cv::Mat result = toGrey(grey, kAnySize, buffer);
    EXPECT_EQ(result.data, grey.data);
    EXPECT_EQ(result.step, grey.step);
    EXPECT_EQ(result.size(), grey.size());
  }
  EXPECT_TRUE(buffer.grey.empty());
}

TEST(GreyImage, EveryValueOfSixteenBitsIsRounded) {
  cv::Mat image(256, 256, CV_16U);
  for (int v = 0; v < 65536; ++v) image.at<std::uint16_t>(v / 256, v % 256) = std::uint16_t(v);
  GreyBuffer buffer;
  const cv::Mat grey = toGrey(image, kAnySize, buffer), eight = toEightBits(image);
  ASSERT_EQ(grey.type(), CV_8U);
  for (int v = 0; v < 65536; ++v) {
    ASSERT_EQ(grey.at<std::uint8_t>(v / 256, v % 256), std::lround(v / 257.0)) << v;
    ASSERT_EQ(eight.at<std::uint8_t>(v / 256, v % 256), std::lround(v / 257.0)) << v;
  }
}

TEST(GreyImage, BitsAreThoseOfCameras) {
  for (const auto& [largest, bits] : {std::pair{0, 8},
                                      {255, 8},
                                      {256, 10},
                                      {1023, 10},
                                      {1024, 12},
                                      {4095, 12},
                                      {4096, 14},
                                      {16383, 14},
                                      {16384, 16},
                                      {65535, 16}}) {
    EXPECT_EQ(significantBits(largest), bits) << largest;
  }
}

TEST(GreyImage, FewerBitsAreStretched) {
  cv::Mat image(64, 64, CV_16U);
  for (int v = 0; v < 4096; ++v) image.at<std::uint16_t>(v / 64, v % 64) = std::uint16_t(v);
  EXPECT_EQ(largestValue(image), 4095);
  const cv::Mat eight = toEightBits(image, 12);
  for (int v = 0; v < 4096; ++v)
    ASSERT_EQ(eight.at<std::uint8_t>(v / 64, v % 64), std::lround(v * 255 / 4095.0));
  EXPECT_EQ(toEightBits(image, 10).at<std::uint8_t>(63, 63), 255);
}

TEST(GreyImage, LargestValueIsThatOfColourAndNotOfAlpha) {
  cv::Mat image(5, 6, CV_16UC4, cv::Scalar(1, 2, 3, 65535));
  EXPECT_EQ(largestValue(image), 3);
  image.at<cv::Vec4w>(4, 5)[0] = 700;
  EXPECT_EQ(largestValue(image), 700);
}

TEST(GreyImage, ColourIsThatOfOpenCV) {
  GreyBuffer buffer;
  for (const auto& [channels, code] :
       {std::make_pair(3, cv::COLOR_BGR2GRAY), std::make_pair(4, cv::COLOR_BGRA2GRAY)}) {
    const cv::Mat image = noise(CV_8UC(channels)), deep = noise(CV_16UC(channels));
    cv::Mat expected, eight;
    cv::cvtColor(image, expected, code);
    EXPECT_EQ(cv::norm(toGrey(image, kAnySize, buffer), expected, cv::NORM_INF), 0);
    deep.convertTo(eight, CV_8U, 1 / 257.0);
    cv::cvtColor(eight, expected, code);
    EXPECT_EQ(cv::norm(toGrey(deep, kAnySize, buffer), expected, cv::NORM_INF), 0);
  }
}

TEST(GreyImage, MemoryIsKept) {
  GreyBuffer buffer;
  const std::uint8_t* const memory = toGrey(noise(CV_8UC3), kAnySize, buffer).data;
  EXPECT_EQ(toGrey(noise(CV_8UC4, {20, 30}), kAnySize, buffer).data, memory);
  EXPECT_EQ(toGrey(noise(CV_16U), kAnySize, buffer).data, memory);
}

TEST(GreyImage, LargeImagesAreReduced) {
  GreyBuffer buffer;
  for (const int type : {CV_8U, CV_8UC3, CV_16U}) {
    const cv::Mat image = noise(type, {400, 100}), grey = toGrey(image, kAnySize, buffer).clone();
    cv::Mat expected;
    cv::resize(grey, expected, {200, 50}, 0, 0, cv::INTER_AREA);
    const cv::Mat result = toGrey(image, 0.01, buffer);
    ASSERT_EQ(result.size(), cv::Size(200, 50));
    EXPECT_EQ(cv::norm(result, expected, cv::NORM_INF), 0);
    EXPECT_EQ(toGrey(image, 0.04, buffer).size(), image.size());
  }
}

TEST(GreyImage, OnlyPartsAreDetached) {
  const cv::Mat image = noise(CV_8U), part = image({10, 5, 20, 30});
  EXPECT_EQ(detached(image).data, image.data);
  EXPECT_NE(detached(part).data, part.data);
  EXPECT_EQ(cv::norm(detached(part), part, cv::NORM_INF), 0);
}

TEST(GreyImage, OtherTypesAreRefused) {
  for (const int type : {CV_8U, CV_8UC3, CV_8UC4, CV_16U, CV_16UC3, CV_16UC4}) checkImage(noise(type));
  for (const int type : {CV_8UC2, CV_8S, CV_16S, CV_16UC2, CV_32F, CV_8UC(5)}) {
    EXPECT_EQ(errorOf<std::invalid_argument>([&] { checkImage(cv::Mat(3, 3, type)); }),
              "image has type " + cv::typeToString(type) +
                  "; needed: 8 or 16 bits with 1, 3 (BGR) or 4 (BGRA) channels");
  }
}

}  // namespace
}  // namespace corrsel::core
