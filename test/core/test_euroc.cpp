#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "datasets/euroc.h"
#include "posed_scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class Euroc : public PosedScene {
 protected:
  static constexpr std::int64_t kStart = 1403636579763555584;

  /// Of the body, which looks along its x axis, in the world.
  static RigidMotion bodyAt(double time) {
    const RigidMotion upright =
        pose({0, 0.1 * time, 0.2 * time}, {0.5 * time - 0.2, 0.1 * time, -0.2 * time});
    return upright * RigidMotion{{0, -1, 0, 0, 0, -1, 1, 0, 0}, {}};
  }

  /// From the frame of a camera to that of the body.
  static RigidMotion extrinsics(int camera) {
    return RigidMotion{{0, 0, 1, -1, 0, 0, 0, -1, 0}, {0.1, camera == 0 ? 0.15 : -0.15, 0.05}} *
           pose({0.01 * camera, 0.02, -0.01}, {0, 0, 0});
  }

  static std::string matrixText(const RigidMotion& motion) {
    std::string text;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) text += std::to_string(motion.rotation(row, column)) + ", ";
      text += std::to_string(motion.translation[row]) + ", ";
    }
    return "T_BS:\n  cols: 4\n  rows: 4\n  data: [" + text + "0.0, 0.0, 0.0, 1.0]\n";
  }

  static std::string sensorText(int camera) {
    return "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor\n" +
           matrixText(extrinsics(camera)) +
           "rate_hz: 20\nresolution: [320, 240]\ncamera_model: pinhole\nintrinsics: [260, 255, 163, 117] "
           "#fu, "
           "fv, cu, cv\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [-0.2, 0.05, 0.001, -0.001]\n";
  }

  static std::string stampOf(double time) {
    return std::to_string(kStart + static_cast<std::int64_t>(std::llround(time * 1e9)));
  }

  void writeSequence(const std::string& folder) const {
    const std::string sensors = folder + "/mav0/";
    for (const int camera : {0, 1}) {
      const std::string own = sensors + "cam" + std::to_string(camera) + "/";
      std::string table = "#timestamp [ns],filename\r\n";
      for (int i = 0; i < 5; ++i) {
        const double time = 0.1 * i + 0.002;
        table += stampOf(time) + "," + stampOf(time) + ".png\r\n";
        writeView(own + "data/" + stampOf(time) + ".png", bodyAt(time) * extrinsics(camera),
                  {-0.2, 0.05, 0.001, -0.001});
      }
      write(own + "data.csv", table);
      write(own + "sensor.yaml", sensorText(camera));
    }
    std::string poses = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], ...\n";
    for (int i = 0; i < 100; ++i) {
      const RigidMotion at = bodyAt(0.005 * i);
      const cv::Vec4d q = quaternion(at.rotation);
      poses += stampOf(0.005 * i);
      for (int k = 0; k < 3; ++k) poses += "," + std::to_string(at.translation[k]);
      for (int k = 0; k < 4; ++k) poses += "," + std::to_string(q[k]);
      poses += ",0,0,0,0,0,0,0,0,0\n";
    }
    write(sensors + "state_groundtruth_estimate0/data.csv", poses);
  }

  PosedPairReader open() const { return PosedPairReader(readEuroc("mine", path()), path()); }
};

TEST_F(Euroc, StereoPairsAndSteps) {
  writeSequence("MH_01_easy");
  write("corrsel.yaml", "step: 2\n");
  EXPECT_TRUE(hasEuroc(path()));
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 5u + 3u);
  EXPECT_EQ(reader.id(0).text(), "mine/MH_01_easy/" + stampOf(0.002) + "-stereo");
  EXPECT_EQ(reader.id(5).text(), "mine/MH_01_easy/" + stampOf(0.002) + "-" + stampOf(0.202));
  for (std::size_t i = 0; i < 8; ++i) {
    const double time = 0.1 * static_cast<double>(i % 5) + 0.002;
    const ImagePair pair = reader.read(i);
    EXPECT_EQ(pair.truth.kind, TruthKind::kFundamental);
    EXPECT_EQ(pair.left_name + pair.right_name, "") << "matches in undistorted images do not fit the files";
    expectTruth(pair, bodyAt(time) * extrinsics(0));
  }
  EXPECT_NEAR(cv::norm(reader.read(0).truth.pose->translation), 0.3, 1e-6);
  ASSERT_EQ(reader.remarks().size(), 4u);
  EXPECT_TRUE(contains(reader.remarks()[0], "MH_01_easy: images of cam0 (320x240 px) are undistorted"));
  EXPECT_TRUE(
      contains(reader.remarks()[2], "5 of 5 stereo pairs are used (max_pairs in corrsel.yaml), 0 of 5"));
  EXPECT_EQ(reader.files().size(), 1u + 5u + 10u);
}

TEST_F(Euroc, ImagesOfEquidistantLensesStayRaw) {
  writeSequence("room");
  write("corrsel.yaml", "step: 2\n");
  const cv::Vec4d distortion(-0.01, 0.02, -0.005, 0.001);
  for (const int camera : {0, 1}) {
    const std::string own = "room/mav0/cam" + std::to_string(camera) + "/";
    std::string text = sensorText(camera);
    const std::size_t lens = text.find("distortion_model");
    // The words of Kalibr.
    text.replace(lens, std::string::npos,
                 "distortion_model: equidistant\ndistortion_coeffs: [-0.01, 0.02, -0.005, 0.001]\n");
    write(own + "sensor.yaml", text);
    for (int i = 0; i < 5; ++i) {
      const double time = 0.1 * i + 0.002;
      writeFisheyeView(own + "data/" + stampOf(time) + ".png", bodyAt(time) * extrinsics(camera), distortion);
    }
  }
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 5u + 3u);
  EXPECT_EQ(reader.remarks().size(), 2u) << "nothing is undistorted";
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    expectFisheyeTruth(pair, bodyAt(0.1 * static_cast<double>(i % 5) + 0.002) * extrinsics(0));
    EXPECT_EQ(pair.left_camera->matrix, camera());
    EXPECT_EQ(pair.right_camera->distortion[2], -0.005);
  }
}

TEST_F(Euroc, OneKindOfPairsCanBeChosen) {
  writeSequence("V1");
  write("corrsel.yaml", "pairs: stereo\nmax_pairs: 2\n");
  EXPECT_EQ(open().size(), 2u);
  write("corrsel.yaml", "pairs: steps\nstep: 1\n");
  EXPECT_EQ(open().size(), 4u);
}

TEST_F(Euroc, WhatIsMissingIsRemarked) {
  writeSequence("V1");
  write("corrsel.yaml", "step: 1\n");
  std::filesystem::remove_all(path("V1/mav0/state_groundtruth_estimate0"));
  const PosedPairReader stereo = open();
  EXPECT_EQ(stereo.size(), 5u);
  EXPECT_EQ(stereo.remarks().back(),
            "V1: there are no pairs of different times, because mav0/state_groundtruth_estimate0 is missing");
  std::filesystem::remove_all(path("V1/mav0/cam1"));
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { open(); }),
               "V1: there are no stereo pairs, because mav0/cam1 is missing; V1: there are no pairs of"));
}

TEST_F(Euroc, TheGroundTruthMayBeThatOfAnotherBody) {
  writeSequence("V1");
  write("corrsel.yaml", "pairs: steps\nstep: 2\n");
  // The trajectory is that of a marker, which is turned and shifted against the body.
  const RigidMotion marker = pose({0.3, -0.2, 0.5}, {0.1, 0.2, -0.1});
  std::string poses;
  for (int i = 0; i < 100; ++i) {
    const RigidMotion at = bodyAt(0.005 * i) * marker;
    const cv::Vec4d q = quaternion(at.rotation);
    poses += stampOf(0.005 * i);
    for (int k = 0; k < 3; ++k) poses += "," + std::to_string(at.translation[k]);
    for (int k = 0; k < 4; ++k) poses += "," + std::to_string(q[k]);
    poses += "\n";
  }
  write("V1/mav0/state_groundtruth_estimate0/data.csv", poses);
  write("V1/mav0/state_groundtruth_estimate0/sensor.yaml", matrixText(marker));
  expectTruth(open().read(0), bodyAt(0.002) * extrinsics(0));
}

TEST_F(Euroc, FaultsNameFileAndRemedy) {
  const auto faultOf = [&](const std::string& file, const std::string& from, const std::string& to) {
    writeSequence("V1");
    write("corrsel.yaml", "pairs: steps\nstep: 1\n");
    std::string text = from.empty() ? "" : sensorText(0);
    if (!from.empty()) text.replace(text.find(from), from.size(), "");
    write("V1/mav0/" + file, text + to);
    const PosedPairReader reader = open();
    EXPECT_EQ(reader.id(0).text(), "mine/V1/all");
    return errorOf<DatasetError>([&] { reader.read(0); });
  };
  const std::string sensor = path("V1/mav0/cam0/sensor.yaml") + ": ";
  EXPECT_TRUE(
      mentions(faultOf("cam0/sensor.yaml", "distortion_model: radial-tangential", "distortion_model: fov\n"),
               {sensor, "fov", "equidistant", "undistort the images of other cameras"}));
  EXPECT_TRUE(mentions(faultOf("cam0/sensor.yaml", "camera_model: pinhole", "camera_model: omni\n"),
                       {sensor, "omni", "pinhole"}));
  EXPECT_TRUE(contains(faultOf("cam0/sensor.yaml", "intrinsics: [260, 255, 163, 117]", ""),
                       sensor + "'intrinsics' is missing"));
  EXPECT_TRUE(mentions(faultOf("cam0/sensor.yaml", "intrinsics: [260, 255, 163, 117]", "intrinsics: [1, 2]"),
                       {sensor, "intrinsics", "2", "4"}));
  EXPECT_TRUE(contains(
      faultOf("cam0/sensor.yaml", "intrinsics: [260, 255, 163, 117]", "intrinsics: [260, 255, 900, 117]"),
      sensor + "cam0 has its principal point at (900, 117), outside its images of 320x240"));
  EXPECT_TRUE(contains(faultOf("cam0/sensor.yaml", "0.0, 0.0, 0.0, 1.0]", ""), "not readable as YAML"));
  EXPECT_TRUE(contains(faultOf("cam0/sensor.yaml", "", "one line\n"), sensor + "has no lines 'key: value'"));
  EXPECT_TRUE(contains(faultOf("cam0/sensor.yaml", matrixText(extrinsics(0)), "T_BS: unknown\n"),
                       sensor + "'T_BS' is not a list of numbers"));
  EXPECT_TRUE(contains(faultOf("cam0/sensor.yaml", "resolution: [320, 240]", "resolution: [1e9, 240]"),
                       sensor + "the size of the images, 1e+09x240, is not one of 1 to 1048576"));
  EXPECT_TRUE(contains(faultOf("cam0/data.csv", "", "1403636579763555584\n"),
                       path("V1/mav0/cam0/data.csv") + ": line 1: has 1 entries where 2 are expected"));
  EXPECT_TRUE(contains(faultOf("cam0/data.csv", "", "1.5,a.png\n"),
                       "line 1: entry 1: '1.5' is not a time; write it in nanoseconds"));
  EXPECT_TRUE(contains(faultOf("cam0/data.csv", "", "# nothing\n"), "data.csv: names no image"));
  EXPECT_TRUE(contains(faultOf("state_groundtruth_estimate0/data.csv", "", "1,2,3\n"),
                       "estimate0/data.csv: line 1: has 3 entries, at least 8 are expected"));
  writeSequence("V1");
  std::filesystem::remove(path("V1/mav0/cam0/sensor.yaml"));
  const PosedPairReader reader = open();
  EXPECT_EQ(errorOf<DatasetError>([&] {
              reader.read(0);
            }).find(sensor + "the file is missing; a sequence of EuRoC holds mav0/cam0"),
            0u);
}

}  // namespace
}  // namespace corrsel::core
