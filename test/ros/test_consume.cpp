#include <gtest/gtest.h>

#include <limits>

#include "corrsel/ros/consume.h"

namespace corrsel {
namespace {

/// Three matches; the first two share the left feature 7.
Correspondences example() {
  Correspondences msg;
  msg.left_x = {1, 1, 5};
  msg.left_y = {2, 2, 6};
  msg.right_x = {10, 20, 30};
  msg.right_y = {11, 21, 31};
  msg.distance = {0.5F, 0.25F, 0.75F};
  msg.left_index = {7, 7, 3};
  msg.right_index = {0, 1, 2};
  return msg;
}

TEST(Consume, PointsAreThoseOfTheMessage) {
  const Correspondences msg = example();
  EXPECT_EQ(leftPoints(msg), (std::vector<cv::Point2f>{{1, 2}, {1, 2}, {5, 6}}));
  EXPECT_EQ(rightPoints(msg), (std::vector<cv::Point2f>{{10, 11}, {20, 21}, {30, 31}}));
  EXPECT_TRUE(leftPoints(Correspondences()).empty());
}

TEST(Consume, ASharedFeatureIsOneKeypoint) {
  const KeypointsAndMatches result = toKeypoints(example());
  ASSERT_EQ(result.left.size(), 2U);
  ASSERT_EQ(result.right.size(), 3U);
  ASSERT_EQ(result.matches.size(), 3U);
  EXPECT_EQ(result.left[0].pt, cv::Point2f(1, 2));
  EXPECT_EQ(result.left[0].class_id, 7);
  EXPECT_EQ(result.left[1].class_id, 3);
  EXPECT_EQ(result.matches[1].queryIdx, 0);
  EXPECT_EQ(result.matches[1].trainIdx, 1);
  EXPECT_EQ(result.matches[1].distance, 0.25F);
  EXPECT_EQ(result.matches[2].queryIdx, 1);
  EXPECT_EQ(result.left[0].size, 0);
  EXPECT_EQ(result.left[0].angle, -1);
}

TEST(Consume, WithoutFeatureNumbersEveryMatchHasItsKeypoints) {
  Correspondences msg = example();
  msg.left_index.clear();
  msg.right_index.clear();
  msg.distance.clear();
  const KeypointsAndMatches result = toKeypoints(msg);
  ASSERT_EQ(result.left.size(), 3U);
  EXPECT_EQ(result.left[1].class_id, -1);
  EXPECT_EQ(result.matches[1].queryIdx, 1);
  EXPECT_EQ(result.matches[1].distance, std::numeric_limits<float>::max());
  msg.probability = {0.25F, 1, 0.75F};
  EXPECT_EQ(toKeypoints(msg).matches[2].distance, 0.25F) << "a probable match is a near one";
}

TEST(Consume, FramesGiveSizeAndAngle) {
  Correspondences msg = example();
  // Radius 3 turned by 90 degrees; an ellipse of half axes 2 and 8; radius 1 turned by -90 degrees.
  msg.left_frame = {0, -3, 1, 3, 0, 2, 2, 0, 1, 0, 8, 2, 0, 1, 5, -1, 0, 6};
  msg.left_index.clear();
  const KeypointsAndMatches result = toKeypoints(msg);
  EXPECT_FLOAT_EQ(result.left[0].size, 6);
  EXPECT_FLOAT_EQ(result.left[0].angle, 90);
  EXPECT_FLOAT_EQ(result.left[1].size, 8);
  EXPECT_FLOAT_EQ(result.left[1].angle, 0);
  EXPECT_FLOAT_EQ(result.left[2].angle, 270);
  EXPECT_EQ(result.right[0].size, 0);
}

TEST(Consume, SelectedRowsAreTheOnesOfTheMask) {
  Selection msg;
  msg.mask = {0, 1, 0, 1};
  msg.n_input = 4;
  EXPECT_EQ(selectedRows(msg), (std::vector<std::uint32_t>{1, 3}));
  EXPECT_TRUE(selectedRows(Selection()).empty());
  msg.n_input = 5;
  EXPECT_THROW(selectedRows(msg), std::invalid_argument);
}

TEST(Consume, WrongLengthsAreNamed) {
  const auto complaint = [](void (*damage)(Correspondences&)) -> std::string {
    Correspondences msg = example();
    damage(msg);
    try {
      toKeypoints(msg);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint([](Correspondences& msg) { msg.left_y.pop_back(); }),
            "Correspondences message: left_y has 2 elements, expected 3");
  EXPECT_EQ(complaint([](Correspondences& msg) { msg.right_x.push_back(0); }),
            "Correspondences message: right_x has 4 elements, expected 3");
  EXPECT_EQ(complaint([](Correspondences& msg) { msg.distance.pop_back(); }),
            "Correspondences message: distance has 2 elements, expected 0 or 3");
  EXPECT_EQ(complaint([](Correspondences& msg) { msg.probability = {1}; }),
            "Correspondences message: probability has 1 elements, expected 0 or 3");
  EXPECT_EQ(complaint([](Correspondences& msg) { msg.right_index.pop_back(); }),
            "Correspondences message: right_index has 2 elements, expected 0 or 3");
  EXPECT_EQ(complaint([](Correspondences& msg) { msg.left_frame.resize(3); }),
            "Correspondences message: left_frame has 3 elements, expected 0 or 18");
}

}  // namespace
}  // namespace corrsel
