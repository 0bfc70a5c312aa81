#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/ros/features.h"
#include "features/parts/feature_list.h"

namespace corrsel {
namespace {

core::Features example() {
  core::Features features;
  features.keypoints = {{1.5F, 2.5F, 8, 90, 0.75F}, {3, 4, 2, 0, 0.5F}, {5, 6, 4, 359, 0.25F}};
  features.frames = core::similarityFrames(features.keypoints);
  features.descriptors = (cv::Mat_<float>(3, 2) << 1, -2, 0.5F, 0.25F, 1e-3F, 7);
  features.image_size = {640, 480};
  return features;
}

/// A message with descriptors of another type.
template <class Element>
Features withDescriptors(std::uint8_t type, const std::vector<Element>& elements) {
  Features msg = toMsg(example(), {});
  msg.descriptor_type = type;
  msg.descriptor_length = static_cast<std::uint32_t>(elements.size() / 3);
  msg.descriptors.resize(elements.size() * sizeof(Element));
  std::memcpy(msg.descriptors.data(), elements.data(), msg.descriptors.size());
  return msg;
}

std::vector<float> numbersOf(const Features& msg) {
  const cv::Mat descriptors = fromMsg(msg).descriptors;
  EXPECT_EQ(descriptors.type(), CV_32F);
  return descriptors.reshape(1, 1);
}

TEST(FeaturesMessage, RoundTrip) {
  FeatureInfo info, back;
  info.header.stamp = ros::Time(12, 34);
  info.header.frame_id = "camera";
  info.name = "superpoint";
  info.camera.emplace();
  info.camera->matrix = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  info.camera->size = {640, 480};
  info.seconds = 0.25;
  const core::Features features = example(), same = fromMsg(toMsg(features, info), &back);
  ASSERT_EQ(same.keypoints.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(same.keypoints[i].pt, features.keypoints[i].pt);
    EXPECT_EQ(same.keypoints[i].size, features.keypoints[i].size);
    EXPECT_EQ(same.keypoints[i].angle, features.keypoints[i].angle);
    EXPECT_EQ(same.keypoints[i].response, features.keypoints[i].response);
  }
  EXPECT_EQ(same.frames, features.frames);
  EXPECT_EQ(cv::norm(same.descriptors, features.descriptors), 0);
  EXPECT_EQ(same.image_size, features.image_size);
  EXPECT_EQ(back.header.stamp, info.header.stamp);
  EXPECT_EQ(back.header.frame_id, "camera");
  EXPECT_EQ(back.name, "superpoint");
  EXPECT_EQ(back.camera, info.camera);
  EXPECT_EQ(back.seconds, 0.25);
}

TEST(FeaturesMessage, NumbersOfEveryTypeAreCompared) {
  const std::vector<float> expected = {1, 2, 3, 4, 5, 120};
  EXPECT_EQ(numbersOf(withDescriptors<std::uint8_t>(Features::DESCRIPTOR_UINT8, {1, 2, 3, 4, 5, 120})),
            expected);
  EXPECT_EQ(numbersOf(withDescriptors<float>(Features::DESCRIPTOR_FLOAT32, {1, 2, 3, 4, 5, 120})), expected);
  EXPECT_EQ(numbersOf(withDescriptors<double>(Features::DESCRIPTOR_FLOAT64, {1, 2, 3, 4, 5, 120})), expected);
  EXPECT_EQ(numbersOf(withDescriptors<std::int8_t>(Features::DESCRIPTOR_INT8, {-1, 2, 3})),
            (std::vector<float>{-1, 2, 3}));
  // IEEE 754 binary16: 1, -2, 65504.
  EXPECT_EQ(numbersOf(withDescriptors<std::uint16_t>(Features::DESCRIPTOR_FLOAT16, {0x3C00, 0xC000, 0x7BFF})),
            (std::vector<float>{1, -2, 65504}));
}

TEST(FeaturesMessage, BinaryDescriptorsStayBytes) {
  core::Features features = example();
  features.descriptors = (cv::Mat_<std::uint8_t>(3, 2) << 255, 0, 1, 2, 3, 4);
  const Features msg = toMsg(features, {});
  EXPECT_EQ(msg.descriptor_type, Features::DESCRIPTOR_BINARY);
  EXPECT_EQ(msg.descriptors, (std::vector<std::uint8_t>{255, 0, 1, 2, 3, 4}));
  EXPECT_EQ(fromMsg(msg).descriptors.type(), CV_8U);
}

TEST(FeaturesMessage, OptionalArraysMayBeMissing) {
  Features msg = toMsg(example(), {});
  msg.angle.clear();
  msg.score.clear();
  core::Features features = fromMsg(msg);
  EXPECT_TRUE(features.frames.empty()) << "a frame needs size and angle";
  EXPECT_EQ(features.keypoints[0].angle, -1);
  msg.descriptors.clear();
  EXPECT_TRUE(fromMsg(msg).descriptors.empty());
  features = fromMsg(Features());
  EXPECT_TRUE(features.keypoints.empty() && features.descriptors.empty());
}

TEST(FeaturesMessage, WhatDoesNotFitIsNamed) {
  const auto refusal = [](const std::function<void(Features&)>& damage) -> std::string {
    Features msg = toMsg(example(), {});
    damage(msg);
    FeatureInfo info;
    try {
      fromMsg(msg, &info);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal([](Features& m) { m.y.pop_back(); }), "Features message: y has 2 elements, expected 3");
  EXPECT_EQ(refusal([](Features& m) { m.score = {1}; }),
            "Features message: score has 1 elements, expected 0 or 3");
  EXPECT_EQ(refusal([](Features& m) { m.descriptor_type = 6; }),
            "Features message: descriptor_type is 6, which is unknown; use one of DESCRIPTOR_*");
  EXPECT_EQ(refusal([](Features& m) { m.descriptors.pop_back(); }),
            "Features message: descriptors has 23 bytes, expected 3 rows of descriptor_length = 2 elements "
            "of 4 bytes");
  EXPECT_EQ(refusal([](Features& m) { m.width = 0xffffffffU; }), "Features message: width is 4294967295 px");
  EXPECT_NE(refusal([](Features& m) { m.camera.model = 9; }).find("camera: model"), std::string::npos);
  core::Features wrong = example();
  wrong.descriptors.convertTo(wrong.descriptors, CV_64F);
  EXPECT_THROW(toMsg(wrong, {}), std::invalid_argument);
  wrong.descriptors = example().descriptors.rowRange(0, 2);
  EXPECT_THROW(toMsg(wrong, {}), std::invalid_argument);
}

TEST(FeaturesMessage, PointsOfOpticalFlowHaveNoDescriptors) {
  core::Features points = example();
  points.descriptors = cv::Mat();
  const Features msg = toMsg(points, {});
  EXPECT_EQ(msg.x.size(), 3u);
  EXPECT_TRUE(msg.descriptors.empty());
  EXPECT_TRUE(fromMsg(msg).descriptors.empty());
}

}  // namespace
}  // namespace corrsel
