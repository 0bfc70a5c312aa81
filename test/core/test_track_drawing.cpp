#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "corrsel/tracking/track_drawing.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::errorOf;
using testing::mentions;

bool isGround(const cv::Mat& picture, int x, int y) {
  return picture.at<cv::Vec3b>(y, x) == cv::Vec3b(90, 90, 90);
}

TEST(TrackDrawing, DiscAtTheNewestPlaceAndTailThroughTheEarlierOnes) {
  const cv::Mat image(100, 200, CV_8UC1, cv::Scalar(90));
  TrackDrawing drawing(5);
  EXPECT_TRUE(isGround(drawing.draw(image), 50, 20)) << "nothing was added";
  drawing.add({7, 9}, {{20, 20}, {20, 80}});
  drawing.add({7}, {{50, 20}});
  drawing.add({7, 8}, {{80, 20}, {150, 50}});
  const cv::Mat picture = drawing.draw(image);
  ASSERT_EQ(picture.type(), CV_8UC3);
  for (const int x : {22, 35, 50, 65, 80}) EXPECT_FALSE(isGround(picture, x, 20)) << x;
  EXPECT_FALSE(isGround(picture, 150, 50)) << "it has just begun";
  EXPECT_TRUE(isGround(picture, 20, 80)) << "it is not seen in the newest frame";
  EXPECT_NE(picture.at<cv::Vec3b>(20, 80), picture.at<cv::Vec3b>(50, 150)) << "the colour shows the age";
  EXPECT_EQ(image.at<std::uint8_t>(20, 80), 90) << "the image itself stays as it is";
}

TEST(TrackDrawing, TheTailEnds) {
  const cv::Mat image(40, 200, CV_8UC3, cv::Scalar::all(90));
  TrackDrawing drawing(2);
  for (int x = 20; x <= 140; x += 30) drawing.add({1}, {cv::Point2f(static_cast<float>(x), 20)});
  const cv::Mat picture = drawing.draw(image);
  EXPECT_FALSE(isGround(picture, 90, 20));
  EXPECT_TRUE(isGround(picture, 60, 20));
  EXPECT_TRUE(isGround(image, 140, 20)) << "a colour image is not drawn on either";
  drawing.reset();
  EXPECT_TRUE(isGround(drawing.draw(image), 140, 20));
}

TEST(TrackDrawing, WrongInput) {
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] { TrackDrawing(0); }), {"tail", "0"}));
  TrackDrawing drawing(3);
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { drawing.add({1, 2}, {{0, 0}}); }), {"2", "1"}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  drawing.add({1, 2, 3}, {{nan, 5}, {5, std::numeric_limits<float>::infinity()}, {-1e30F, 5}});
  EXPECT_TRUE(isGround(drawing.draw(cv::Mat(10, 10, CV_8UC1, cv::Scalar(90))), 5, 5));
}

}  // namespace
}  // namespace corrsel::core
