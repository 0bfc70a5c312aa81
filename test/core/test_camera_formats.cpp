#include <gtest/gtest.h>

#include <cmath>

#include "cameras.h"
#include "corrsel/camera_formats.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

const cv::Matx33d kMatrix = {500, 0, 320, 0, 510, 240, 0, 0, 1};

template <class Action>
std::string refusal(const Action& action) {
  return errorOf<std::invalid_argument>(action);
}

TEST(CameraFormats, OpenCvsPinholesOfEveryLength) {
  const std::vector<double> numbers = {-0.3, 0.1, 0.001, 0.002, -0.05, 0.3, -0.2, 0.02};
  EXPECT_TRUE(cameraFromOpenCv(kMatrix, {}).isPlainPinhole());
  for (const std::size_t count : {4, 5, 8, 12, 14}) {
    std::vector<double> distortion = numbers;
    distortion.resize(count);
    const Camera camera = cameraFromOpenCv(kMatrix, distortion, {640, 480});
    EXPECT_EQ(camera.model, Camera::Model::kPinhole);
    EXPECT_EQ(camera.matrix, kMatrix);
    EXPECT_EQ(camera.size, cv::Size(640, 480));
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(camera.distortion[i], i < count ? numbers[i] : 0) << count;
    distortion.resize(count <= 5 ? 5 : 8);
    EXPECT_EQ(openCvDistortion(camera), distortion);
  }
}

TEST(CameraFormats, OpenCvsFisheyes) {
  const std::vector<double> distortion = {0.1, -0.2, 0.3, -0.4};
  const Camera camera = cameraFromOpenCvFisheye(kMatrix, distortion);
  EXPECT_EQ(camera.model, Camera::Model::kFisheye);
  EXPECT_EQ(camera.distortion, (std::array<double, 8>{0.1, -0.2, 0.3, -0.4}));
  EXPECT_EQ(openCvDistortion(camera), distortion);
  EXPECT_TRUE(mentions(refusal([] {
                         cameraFromOpenCvFisheye(kMatrix, {1, 2, 3, 4, 5});
                       }),
                       {"5 numbers", "0, 4"}));
}

TEST(CameraFormats, WhatIsNotSupportedOfOpenCvIsNamed) {
  EXPECT_TRUE(mentions(refusal([] {
                         cameraFromOpenCv(kMatrix, {1, 2, 3});
                       }),
                       {"3 numbers", "4, 5, 8, 12, 14"}));
  std::vector<double> tilted(14);
  tilted[12] = 0.25;
  EXPECT_TRUE(mentions(refusal([&] { cameraFromOpenCv(kMatrix, tilted); }),
                       {"distortion[12] = 0.25", "thin prism and tilt", "valid: 0"}));
  EXPECT_TRUE(
      mentions(refusal([] { cameraFromOpenCv(cv::Matx33d::zeros(), {}); }), {"matrix", "positive fx"}));
  EXPECT_TRUE(mentions(refusal([] { openCvDistortion(panoramaCamera()); }),
                       {"equirectangular", "OpenCV", "pinhole"}));
}

TEST(CameraFormats, CameraInfoThereAndBack) {
  for (const auto& [name, camera] : allCameras()) {
    if (camera.model == Camera::Model::kEquirectangular) continue;
    EXPECT_EQ(cameraFromInfo(cameraToInfo(camera)), camera) << name;
  }
  EXPECT_EQ(cameraToInfo(plainCamera()).distortion_model, "plumb_bob");
  EXPECT_EQ(cameraToInfo(plainCamera()).d.size(), 5u);
  EXPECT_EQ(cameraToInfo(rationalCamera()).distortion_model, "rational_polynomial");
  EXPECT_EQ(cameraToInfo(rationalCamera()).d.size(), 8u);
  EXPECT_EQ(cameraToInfo(fisheyeCamera()).distortion_model, "equidistant");
  EXPECT_EQ(cameraToInfo(fisheyeCamera()).d.size(), 4u);
  EXPECT_THROW(cameraToInfo(panoramaCamera()), std::invalid_argument);
}

TEST(CameraFormats, NamesOfCameraInfo) {
  EXPECT_EQ(cameraFromInfo({{}, "fisheye", {0.1, 0.2, 0, 0}, kMatrix}).model, Camera::Model::kFisheye);
  EXPECT_EQ(cameraFromInfo({{}, "plumb_bob", {0.1, 0.2, 0, 0}, kMatrix}).distortion[1], 0.2);
  EXPECT_TRUE(cameraFromInfo({{}, "plumb_bob", {}, kMatrix}).isPlainPinhole());
  EXPECT_TRUE(cameraFromInfo({{}, "", {0, 0, 0, 0, 0}, kMatrix}).isPlainPinhole());
  EXPECT_TRUE(mentions(refusal([] {
                         cameraFromInfo({{}, "", {0.1, 0, 0, 0, 0}, kMatrix});
                       }),
                       {"distortion_model is empty"}));
  EXPECT_TRUE(mentions(refusal([] {
                         cameraFromInfo({{}, "plumb_bob", std::vector<double>(8), kMatrix});
                       }),
                       {"plumb_bob has 8 numbers", "0, 4, 5"}));
  EXPECT_TRUE(
      mentions(refusal([] {
                 cameraFromInfo({{}, "equi", {}, kMatrix});
               }),
               {"distortion_model 'equi'", "plumb_bob", "rational_polynomial", "equidistant", "fisheye"}));
  EXPECT_TRUE(mentions(refusal([] {
                         cameraFromInfo({{640, 480}, "plumb_bob", {}, cv::Matx33d::zeros()});
                       }),
                       {"matrix = [0 0 0; 0 0 0; 0 0 0]"}));
}

struct ColmapExample {
  ColmapCamera colmap;
  Camera::Model model;
  double fx, fy;
  std::array<double, 8> distortion;
};

TEST(CameraFormats, ColmapsModels) {
  constexpr auto kPinhole = Camera::Model::kPinhole, kFisheye = Camera::Model::kFisheye;
  const std::vector<ColmapExample> examples = {
      {{"SIMPLE_PINHOLE", {}, {500, 320, 240}}, kPinhole, 500, 500, {}},
      {{"PINHOLE", {}, {500, 510, 320, 240}}, kPinhole, 500, 510, {}},
      {{"SIMPLE_RADIAL", {}, {500, 320, 240, 1}}, kPinhole, 500, 500, {1}},
      {{"RADIAL", {}, {500, 320, 240, 1, 2}}, kPinhole, 500, 500, {1, 2}},
      {{"OPENCV", {}, {500, 510, 320, 240, 1, 2, 3, 4}}, kPinhole, 500, 510, {1, 2, 3, 4}},
      {{"FULL_OPENCV", {}, {500, 510, 320, 240, 1, 2, 3, 4, 5, 6, 7, 8}},
       kPinhole,
       500,
       510,
       {1, 2, 3, 4, 5, 6, 7, 8}},
      {{"OPENCV_FISHEYE", {}, {500, 510, 320, 240, 1, 2, 3, 4}}, kFisheye, 500, 510, {1, 2, 3, 4}},
      {{"SIMPLE_RADIAL_FISHEYE", {}, {500, 320, 240, 1}}, kFisheye, 500, 500, {1}},
      {{"RADIAL_FISHEYE", {}, {500, 320, 240, 1, 2}}, kFisheye, 500, 500, {1, 2}}};
  for (const ColmapExample& example : examples) {
    ColmapCamera colmap = example.colmap;
    colmap.size = {640, 480};
    const Camera camera = cameraFromColmap(colmap);
    EXPECT_EQ(camera.model, example.model) << colmap.model;
    EXPECT_EQ(camera.matrix, cv::Matx33d(example.fx, 0, 319.5, 0, example.fy, 239.5, 0, 0, 1))
        << colmap.model;
    EXPECT_EQ(camera.distortion, example.distortion) << colmap.model;
    EXPECT_EQ(camera.size, colmap.size) << colmap.model;
    EXPECT_EQ(cameraFromColmap(cameraToColmap(camera)), camera) << colmap.model;
    colmap.parameters.push_back(0);
    EXPECT_TRUE(mentions(refusal([&] { cameraFromColmap(colmap); }),
                         {colmap.model, std::to_string(colmap.parameters.size()) + " numbers",
                          "valid: " + std::to_string(colmap.parameters.size() - 1)}));
  }
}

TEST(CameraFormats, ToColmap) {
  const ColmapCamera colmap = cameraToColmap(cameraFromOpenCv(kMatrix, {0.1, 0.2, 0.3, 0.4}, {640, 480}));
  EXPECT_EQ(colmap.model, "OPENCV");
  EXPECT_EQ(colmap.parameters, (std::vector<double>{500, 510, 320.5, 240.5, 0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(colmap.size, cv::Size(640, 480));
  EXPECT_EQ(cameraToColmap(cameraFromOpenCv(kMatrix, {})).model, "PINHOLE");
  EXPECT_EQ(cameraToColmap(radtanCamera()).model, "FULL_OPENCV");
  EXPECT_EQ(cameraToColmap(rationalCamera()).model, "FULL_OPENCV");
  EXPECT_EQ(cameraToColmap(fisheyeCamera()).model, "OPENCV_FISHEYE");
  EXPECT_TRUE(mentions(refusal([] { cameraToColmap(plainCamera()); }), {"skew 2", "COLMAP", "valid: 0"}));
  EXPECT_TRUE(mentions(refusal([] { cameraToColmap(panoramaCamera()); }), {"equirectangular", "COLMAP"}));
  EXPECT_TRUE(mentions(refusal([] {
                         cameraFromColmap({"FOV", {640, 480}, {1, 2, 3, 4, 5}});
                       }),
                       {"'FOV'", "OPENCV_FISHEYE", "SIMPLE_RADIAL"}));
}

TEST(CameraFormats, Kalibr) {
  const Camera radtan =
      cameraFromKalibr({"pinhole", {500, 510, 320, 240}, "radtan", {1, 2, 3, 4}, {640, 480}});
  EXPECT_EQ(radtan, cameraFromOpenCv(kMatrix, {1, 2, 3, 4}, {640, 480}));
  const Camera euroc =
      cameraFromKalibr({"pinhole", {500, 510, 320, 240}, "radial-tangential", {1, 2, 3, 4}, {640, 480}});
  EXPECT_EQ(euroc, radtan);
  for (const char* name : {"equidistant", "equi"}) {
    EXPECT_EQ(cameraFromKalibr({"pinhole", {500, 510, 320, 240}, name, {1, 2, 3, 4}, {640, 480}}),
              cameraFromOpenCvFisheye(kMatrix, {1, 2, 3, 4}, {640, 480}));
  }
  const Camera plain = cameraFromKalibr({"pinhole", {500, 510, 320, 240}, "none", {}, {640, 480}});
  EXPECT_EQ(plain, cameraFromOpenCv(kMatrix, {}, {640, 480}));
  for (const Camera& camera : {radtan, plain, fisheyeCamera()}) {
    EXPECT_EQ(cameraFromKalibr(cameraToKalibr(camera)), camera);
  }
  EXPECT_EQ(cameraToKalibr(radtan).distortion_model, "radtan");
  EXPECT_EQ(cameraToKalibr(fisheyeCamera()).distortion_model, "equidistant");
  EXPECT_EQ(cameraToKalibr(plain).distortion_model, "none");
}

TEST(CameraFormats, WhatIsNotSupportedOfKalibrIsNamed) {
  const std::vector<double> intrinsics = {500, 510, 320, 240};
  EXPECT_TRUE(mentions(refusal([&] {
                         cameraFromKalibr({"omni", intrinsics, "radtan", {1, 2, 3, 4}, {}});
                       }),
                       {"camera_model 'omni'", "valid: pinhole"}));
  EXPECT_TRUE(mentions(refusal([&] {
                         cameraFromKalibr({"pinhole", intrinsics, "fov", {1}, {}});
                       }),
                       {"distortion_model 'fov'", "radtan", "equidistant", "none"}));
  EXPECT_TRUE(mentions(refusal([&] {
                         cameraFromKalibr({"pinhole", {1, 2}, "radtan", {1, 2, 3, 4}, {}});
                       }),
                       {"intrinsics has 2", "valid: 4"}));
  EXPECT_TRUE(mentions(refusal([&] {
                         cameraFromKalibr({"pinhole", intrinsics, "radtan", {1, 2}, {}});
                       }),
                       {"distortion_coeffs of radtan has 2", "valid: 4"}));
  EXPECT_TRUE(mentions(refusal([&] {
                         cameraFromKalibr({"pinhole", intrinsics, "none", {1}, {}});
                       }),
                       {"none"}));
  EXPECT_TRUE(
      mentions(refusal([] { cameraToKalibr(radtanCamera()); }), {"distortion[4] = -0.07910379", "Kalibr"}));
  EXPECT_TRUE(mentions(refusal([] { cameraToKalibr(plainCamera()); }), {"skew 2", "Kalibr"}));
}

}  // namespace
}  // namespace corrsel::core
