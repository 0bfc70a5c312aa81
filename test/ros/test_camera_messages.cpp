#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/ros/cameras.h"

namespace corrsel {
namespace {

using Model = core::Camera::Model;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

sensor_msgs::CameraInfo info(const std::string& model, const std::vector<double>& distortion) {
  sensor_msgs::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = model;
  info.D = distortion;
  info.K = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {450, 0, 310, 0, 0, 455, 235, 0, 0, 0, 1, 0};
  return info;
}

void expectRefused(const std::function<void()>& action, const std::vector<std::string>& parts) {
  try {
    action();
    ADD_FAILURE() << "accepted, expected a complaint about " << parts.front();
  } catch (const std::invalid_argument& error) {
    for (const std::string& part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << part << ": " << error.what();
    }
  }
}

cv::Matx33d turn(double x, double y, double z) {
  const cv::Matx33d rx(1, 0, 0, 0, std::cos(x), -std::sin(x), 0, std::sin(x), std::cos(x));
  const cv::Matx33d ry(std::cos(y), 0, std::sin(y), 0, 1, 0, -std::sin(y), 0, std::cos(y));
  const cv::Matx33d rz(std::cos(z), -std::sin(z), 0, std::sin(z), std::cos(z), 0, 0, 0, 1);
  return rz * ry * rx;
}

TEST(CameraMessages, EveryModelOfCameraInfoIsKnown) {
  struct Case {
    std::string name;
    std::vector<double> distortion;
    Model model;
  };
  for (const Case& c : std::vector<Case>{
           {"plumb_bob", {-0.3, 0.1, 0.001, 0.002, -0.05}, Model::kPinhole},
           {"plumb_bob", {-0.3, 0.1, 0.001, 0.002}, Model::kPinhole},
           {"rational_polynomial", {0.3, 0.1, 0.001, 0.002, 0.01, 0.2, 0.05, 0.01}, Model::kPinhole},
           {"equidistant", {-0.02, 0.003, 0.001, 0.0005}, Model::kFisheye},
           {"fisheye", {-0.02, 0.003, 0.001, 0.0005}, Model::kFisheye},
           {"equidistant", {0, 0, 0, 0}, Model::kFisheye},
           {"", {}, Model::kPinhole},
           {"", {0, 0, 0, 0, 0}, Model::kPinhole},
           {"none", {0, 0, 0, 0, 0}, Model::kPinhole},
       }) {
    SCOPED_TRACE(c.name + " with " + std::to_string(c.distortion.size()));
    const core::Camera camera = cameraOf(info(c.name, c.distortion), false);
    EXPECT_EQ(camera.model, c.model);
    EXPECT_EQ(camera.matrix, cv::Matx33d(500, 0, 320, 0, 510, 240, 0, 0, 1));
    EXPECT_EQ(camera.size, cv::Size(640, 480));
    for (std::size_t i = 0; i < camera.distortion.size(); ++i) {
      EXPECT_EQ(camera.distortion[i], i < c.distortion.size() ? c.distortion[i] : 0.0) << i;
    }
  }
}

TEST(CameraMessages, RectifiedImagesHaveTheCameraOfP) {
  for (const char* model : {"plumb_bob", "equidistant", "of_a_driver"}) {
    const core::Camera camera = cameraOf(info(model, {-0.3, 0.1, 0.001, 0.002}), true);
    EXPECT_TRUE(camera.isPlainPinhole());
    EXPECT_EQ(camera.matrix, cv::Matx33d(450, 0, 310, 0, 455, 235, 0, 0, 1));
  }
  EXPECT_TRUE(isRectified("auto", "/stereo/left/image_rect_color/compressed"));
  EXPECT_FALSE(isRectified("auto", "/stereo/left/image_raw"));
  EXPECT_FALSE(isRectified("raw", "/stereo/left/image_rect"));
  EXPECT_TRUE(isRectified("rectified", "/camera/image"));
}

TEST(CameraMessages, BinningAndRegionMoveThePixelsOfACamera) {
  sensor_msgs::CameraInfo reduced = info("plumb_bob", {});
  reduced.roi.x_offset = 100;
  reduced.roi.y_offset = 60;
  reduced.roi.width = 400;
  reduced.roi.height = 300;
  reduced.binning_x = 2;
  reduced.binning_y = 4;
  const cv::Vec3d point(0.3, -0.2, 2.0);
  for (const bool rectified : {false, true}) {
    const core::Camera whole = cameraOf(info("plumb_bob", {}), rectified),
                       part = cameraOf(reduced, rectified);
    EXPECT_EQ(part.size, cv::Size(200, 75));
    const cv::Vec3d in_whole = whole.matrix * point / point[2], in_part = part.matrix * point / point[2];
    EXPECT_NEAR(in_part[0], (in_whole[0] - 100) / 2, 1e-12);
    EXPECT_NEAR(in_part[1], (in_whole[1] - 60) / 4, 1e-12);
  }
}

TEST(CameraMessages, WhatIsNoCalibrationIsNamedWithItsRemedy) {
  const auto with = [](const std::function<void(sensor_msgs::CameraInfo&)>& damage, bool rectified = false) {
    sensor_msgs::CameraInfo message = info("plumb_bob", {-0.3, 0.1, 0.001, 0.002, -0.05});
    damage(message);
    return [message, rectified] { cameraOf(message, rectified); };
  };
  using Info = sensor_msgs::CameraInfo;
  expectRefused(with([](Info& m) { m.K.fill(0); }), {"K is all zero", "not calibrated", "cameracalibrator"});
  expectRefused(with([](Info& m) { m.P.fill(0); }, true), {"P is all zero", "not calibrated"});
  expectRefused(with([](Info& m) { m.K[0] = kNaN; }), {"K is [nan", "finite"});
  expectRefused(with([](Info& m) { m.P[3] = kNaN; }, true), {"P is [450", "finite"});
  expectRefused(with([](Info& m) { m.K[4] = -510; }), {"K is [500", "-510", "focal"});
  expectRefused(with([](Info& m) { m.K[3] = 5; }), {"matrix"});
  expectRefused(with([](Info& m) { m.D[1] = kNaN; }), {"D is [-0.3, nan", "finite"});
  expectRefused(with([](Info& m) { m.D.assign(8, 0.25); }), {"plumb_bob has 8 numbers", "cameracalibrator"});
  expectRefused(with([](Info& m) { m.distortion_model = "equidistant"; }), {"has 5 numbers", "valid: 0, 4"});
  expectRefused(with([](Info& m) { m.distortion_model = "brown"; }),
                {"distortion_model 'brown'", "plumb_bob"});
  expectRefused(with([](Info& m) { m.height = 0; }), {"640x0", "size at which"});
  expectRefused(with([](Info& m) { m.width = 0xffffffffu; }), {"4294967295x480"});
  expectRefused(with([](Info& m) {
                  m.roi.width = m.roi.height = 10;
                  m.roi.x_offset = 0xffffffffu;
                }),
                {"roi, 10x10 at 4294967295"});
  expectRefused(with([](Info& m) { m.binning_y = 481; }), {"binning (1x481)"});
  EXPECT_NO_THROW(with([](Info& m) { m.K.fill(0); }, true)()) << "K is not used";
  EXPECT_NO_THROW(with([](Info& m) { m.P.fill(0); })()) << "P is not used";
}

TEST(CameraMessages, CameraInfoRoundTripKeepsEverything) {
  core::Camera camera;
  camera.matrix = {500, 0.5, 320.25, 0, 510, 240.75, 0, 0, 1};
  camera.size = {640, 480};
  for (const auto& [model, distortion] : std::vector<std::pair<Model, std::array<double, 8>>>{
           {Model::kPinhole, {}},
           {Model::kPinhole, {-0.3, 0.1, 0.001, 0.002, -0.05}},
           {Model::kPinhole, {-0.3, 0.1, 0.001, 0.002, -0.05, 0, 0, 0.125}},
           {Model::kFisheye, {-0.02, 0.003, 0.001, 0.0005}},
           {Model::kFisheye, {}},
       }) {
    camera.model = model;
    camera.distortion = distortion;
    EXPECT_EQ(cameraOf(cameraInfo(camera), false), camera);
  }
  core::Camera plain = camera;
  plain.model = Model::kPinhole;
  plain.distortion = {};
  EXPECT_EQ(cameraOf(cameraInfo(camera), true), plain) << "P = [K 0]";
  camera.model = Model::kEquirectangular;
  expectRefused([&] { cameraInfo(camera); }, {"equirectangular"});
}

TEST(CameraMessages, MessageRoundTripKeepsEverything) {
  core::Camera camera;
  camera.matrix = {500, 0.5, 320.25, 0, 510, 240.75, 0, 0, 1};
  camera.size = {640, 480};
  for (const Model model : {Model::kPinhole, Model::kFisheye, Model::kEquirectangular}) {
    camera.model = model;
    camera.distortion = {};
    if (model == Model::kEquirectangular) {
      camera.matrix = cv::Matx33d::eye();
    } else {
      camera.distortion = {-0.3, 0.1, 0.001, 0.002};
    }
    const std::optional<core::Camera> back = fromMsg(toMsg(std::make_optional(camera)));
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, camera);
  }
  EXPECT_FALSE(fromMsg(toMsg(std::nullopt)));
  EXPECT_FALSE(fromMsg(Camera())) << "a message that was filled in by hand holds zeros";
}

TEST(CameraMessages, EveryModelHasItsConstant) {
  const auto number = [](Model model) {
    core::Camera camera;
    camera.model = model;
    return toMsg(std::make_optional(camera)).model;
  };
  EXPECT_EQ(number(Model::kPinhole), Camera::MODEL_PINHOLE);
  EXPECT_EQ(number(Model::kFisheye), Camera::MODEL_FISHEYE);
  EXPECT_EQ(number(Model::kEquirectangular), Camera::MODEL_EQUIRECTANGULAR);
}

TEST(CameraMessages, NonsenseIsNamed) {
  core::Camera camera;
  camera.size = {640, 480};
  Camera msg = toMsg(std::make_optional(camera));
  msg.model = 4;
  expectRefused([&] { fromMsg(msg); }, {"model is 4"});
  msg = toMsg(std::make_optional(camera));
  msg.width = 0xffffffffu;
  expectRefused([&] { fromMsg(msg); }, {"size is 4294967295x480"});
  msg = toMsg(std::make_optional(camera));
  msg.matrix[0] = kNaN;
  expectRefused([&] { fromMsg(msg); }, {"matrix"});
}

/// Two raw cameras that were calibrated together: 0.12 m and something apart, both turned.
std::pair<sensor_msgs::CameraInfo, sensor_msgs::CameraInfo> stereo() {
  sensor_msgs::CameraInfo left = info("plumb_bob", {}), right = left;
  const cv::Matx33d left_turn = turn(0.02, -0.05, 0.01), right_turn = turn(-0.03, 0.04, 0.02);
  std::copy_n(left_turn.val, 9, left.R.begin());
  std::copy_n(right_turn.val, 9, right.R.begin());
  left.P[3] = 450 * 0.01;
  right.P[3] = -450 * 0.12;
  right.P[7] = 455 * 0.003;
  return {left, right};
}

/// Pixel of a point of the rectified frame that the cameras share.
cv::Vec2d seen(const sensor_msgs::CameraInfo& info, const cv::Vec3d& point) {
  const cv::Matx34d p(info.P.data());
  const cv::Vec3d pixel = p * cv::Vec4d(point[0], point[1], point[2], 1);
  return {pixel[0] / pixel[2], pixel[1] / pixel[2]};
}

TEST(CameraMessages, ARigIsThePoseBetweenTheCamerasOfTheImages) {
  const auto [left, right] = stereo();
  const cv::Matx33d m(450, 0, 310, 0, 455, 235, 0, 0, 1);
  const cv::Vec3d point(0.4, -0.3, 3.0), from_left = point + cv::Vec3d(0.01, 0, 0);
  const cv::Vec2d expected = seen(right, point);
  for (const bool left_rectified : {false, true}) {
    for (const bool right_rectified : {false, true}) {
      const auto rig = rigOf(left, left_rectified, right, right_rectified);
      ASSERT_TRUE(rig);
      const cv::Matx33d left_turn(left.R.data()), right_turn(right.R.data());
      const cv::Vec3d in_left = left_rectified ? from_left : left_turn.t() * from_left;
      const cv::Vec3d in_right = rig->rotation * in_left + rig->translation;
      const cv::Vec3d pixel = m * (right_rectified ? in_right : right_turn * in_right);
      EXPECT_NEAR(pixel[0] / pixel[2], expected[0], 1e-9);
      EXPECT_NEAR(pixel[1] / pixel[2], expected[1], 1e-9);
      EXPECT_NEAR(cv::norm(rig->translation), std::hypot(0.13, 0.003), 1e-12) << "m";
    }
  }
}

TEST(CameraMessages, CamerasThatWereCalibratedAloneAreNoRig) {
  const auto [left, right] = stereo();
  const sensor_msgs::CameraInfo alone = info("plumb_bob", {});
  EXPECT_FALSE(rigOf(alone, true, alone, true));
  EXPECT_FALSE(rigOf(left, false, left, false)) << "the same camera";
  sensor_msgs::CameraInfo bare = right;
  bare.P.fill(0);
  EXPECT_FALSE(rigOf(left, false, bare, false));
  bare = right;
  bare.P[3] = kNaN;
  EXPECT_FALSE(rigOf(left, false, bare, false));
  bare = right;
  bare.R.fill(0);
  EXPECT_FALSE(rigOf(left, false, bare, false));
  EXPECT_TRUE(rigOf(left, false, bare, true)) << "R belongs to raw images";
}

}  // namespace
}  // namespace corrsel
