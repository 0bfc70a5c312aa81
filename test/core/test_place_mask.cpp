#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "features/parts/place_mask.h"

namespace corrsel::core {
namespace {

TEST(PlaceMask, AllowsAllPlacesByDefault) {
  const PlaceMask mask;
  EXPECT_TRUE(mask.everywhere());
  EXPECT_TRUE(mask.allows({-3, 1e6F}));
}

TEST(PlaceMask, TheNearestPixelDecides) {
  cv::Mat pixels(4, 4, CV_8U, cv::Scalar(0));
  pixels.at<std::uint8_t>(1, 2) = 1;
  const PlaceMask mask(pixels, {});
  EXPECT_FALSE(mask.everywhere());
  EXPECT_TRUE(mask.allows({2, 1}));
  EXPECT_TRUE(mask.allows({2.49F, 0.51F}));
  EXPECT_FALSE(mask.allows({2.51F, 1}));
  EXPECT_FALSE(mask.allows({2, 1.51F}));
}

TEST(PlaceMask, PlacesBeyondTheBorderBelongToTheBorder) {
  cv::Mat pixels(4, 4, CV_8U, cv::Scalar(0));
  pixels.at<std::uint8_t>(3, 0) = 255;
  const PlaceMask mask(pixels, {});
  EXPECT_TRUE(mask.allows({-9, 9}));
  EXPECT_FALSE(mask.allows({9, 9}));
}

TEST(PlaceMask, ARectangleAllowsWhatOneOfItsPlacesAllows) {
  EXPECT_TRUE(PlaceMask().allowsAny({3, 4, 1, 1}));
  EXPECT_FALSE(PlaceMask().allowsAny({3, 4, 0, 1}));
  cv::Mat pixels(40, 61, CV_8U, cv::Scalar(0));
  const auto allows = [&pixels](const cv::Rect& rectangle) {
    return PlaceMask(pixels, {}).allowsAny(rectangle);
  };
  EXPECT_FALSE(allows({0, 0, 61, 40}));
  pixels.at<std::uint8_t>(19, 27) = 1;  // in the tile of 8 x 8 px at (24, 16)
  EXPECT_TRUE(allows({0, 0, 61, 40}));
  EXPECT_TRUE(allows({27, 19, 1, 1}));
  EXPECT_TRUE(allows({26, 18, 1, 1}));  // up to 26.5, which is rounded to 27
  for (const cv::Rect& far : std::vector<cv::Rect>{{0, 0, 23, 40},
                                                   {32, 0, 29, 40},
                                                   {0, 0, 61, 15},
                                                   {0, 24, 61, 16},
                                                   {-99, -99, 99, 99},
                                                   {61, 40, 9, 9}}) {
    EXPECT_FALSE(allows(far)) << far;
  }
  // Places beyond the border belong to the border.
  pixels = 0;
  pixels.at<std::uint8_t>(39, 60) = 255;
  EXPECT_TRUE(allows({100, 200, 5, 5}));
  EXPECT_TRUE(allows({2000000000, 2000000000, 2000000000, 2000000000}));
  EXPECT_FALSE(allows({-2000000000, -2000000000, 1000000000, 1000000000}));
}

TEST(PlaceMask, NoPlaceOfARefusedRectangleIsAllowed) {
  // Whole, moved and reduced images; the mask allows few places.
  cv::RNG random(4);
  int refused = 0, granted = 0;
  for (const auto& [seen, area] : std::vector<std::pair<cv::Size, cv::Rect>>{
           {{90, 70}, {0, 0, 90, 70}}, {{50, 30}, {10, 20, 50, 30}}, {{31, 17}, {7, 9, 80, 45}}}) {
    cv::Mat pixels(70, 90, CV_8U, cv::Scalar(0));
    for (int i = 0; i < 4; ++i) {
      const int x = random.uniform(0, 90), y = random.uniform(0, 70);
      pixels.at<std::uint8_t>(y, x) = 1;
    }
    const PlaceMask mask(pixels, AreaTransform(seen, area));
    for (int i = 0; i < 400; ++i) {
      const int height = random.uniform(1, 12), width = random.uniform(1, 12);
      const int top = random.uniform(-3, seen.height), left = random.uniform(-3, seen.width);
      const cv::Rect rectangle(left, top, width, height);
      bool allowed = false;
      for (float y = 0; y <= 1; y += 1.0F / 32) {
        for (float x = 0; x <= 1; x += 1.0F / 32) {
          allowed |= mask.allows({float(rectangle.x) - 0.5F + x * float(rectangle.width),
                                  float(rectangle.y) - 0.5F + y * float(rectangle.height)});
        }
      }
      if (mask.allowsAny(rectangle)) {
        ++granted;
      } else {
        ++refused;
        ASSERT_FALSE(allowed) << rectangle;
      }
    }
  }
  EXPECT_GT(refused, 600);
  EXPECT_GT(granted, 50);
}

TEST(PlaceMask, DropsFeaturesWithTheirFramesAndDescriptors) {
  cv::Mat pixels(10, 10, CV_8U, cv::Scalar(255));
  pixels.rowRange(0, 5) = 0;
  Features features;
  for (int i = 0; i < 10; ++i) {
    features.keypoints.emplace_back(float(i), float(i), 1.0F);
    features.frames.push_back({1, 0, float(i), 0, 1, float(i)});
    features.descriptors.push_back(cv::Mat(1, 2, CV_8U, cv::Scalar(i)));
  }
  PlaceMask(pixels, {}).apply(features);
  ASSERT_EQ(features.keypoints.size(), 5u);
  ASSERT_EQ(features.frames.size(), 5u);
  ASSERT_EQ(features.descriptors.rows, 5);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(features.keypoints[std::size_t(i)].pt.x, float(i + 5));
    EXPECT_EQ(features.frames[std::size_t(i)][2], float(i + 5));
    EXPECT_EQ(features.descriptors.at<std::uint8_t>(i, 1), i + 5);
  }
}

TEST(AreaTransform, MapsPixelsOfAReducedAreaToTheWholeImage) {
  // 100 x 60 px at (10, 20), seen at half the size: the centre of a seen pixel is between two pixels.
  const AreaTransform to_whole({50, 30}, {10, 20, 100, 60});
  EXPECT_EQ(to_whole({0, 0}), cv::Point2f(10.5F, 20.5F));
  EXPECT_EQ(to_whole({49, 29}), cv::Point2f(108.5F, 78.5F));
  Features features;
  features.keypoints.emplace_back(4.0F, 6.0F, 3.0F, 30.0F);
  features.frames.push_back({1, 2, 4, 3, 4, 6});
  to_whole.apply(features);
  EXPECT_EQ(features.keypoints[0].pt, cv::Point2f(18.5F, 32.5F));
  EXPECT_EQ(features.keypoints[0].size, 6);
  EXPECT_EQ(features.keypoints[0].angle, 30);
  EXPECT_EQ(features.frames[0], (AffineFrame{2, 4, 18.5F, 6, 8, 32.5F}));
}

TEST(AreaTransform, AnAreaOfTheSameSizeIsOnlyShifted) {
  EXPECT_EQ(AreaTransform({100, 60}, {10, 20, 100, 60})({0.1F, 0.2F}), cv::Point2f(10.1F, 20.2F));
  EXPECT_EQ(AreaTransform()({0.1F, 0.2F}), cv::Point2f(0.1F, 0.2F));
}

TEST(PlaceMask, IsLookedUpInPixelsOfTheWholeImage) {
  cv::Mat pixels(80, 120, CV_8U, cv::Scalar(0));
  pixels.at<std::uint8_t>(33, 19) = 1;
  const PlaceMask mask(pixels, AreaTransform({50, 30}, {10, 20, 100, 60}));
  EXPECT_TRUE(mask.allows({4, 6}));  // (18.5, 32.5)
  EXPECT_FALSE(mask.allows({4.6F, 6}));
}

}  // namespace
}  // namespace corrsel::core
