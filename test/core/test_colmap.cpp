#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "colmap_files.h"
#include "datasets/colmap.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class Colmap : public ColmapFiles {
 protected:
  /// Ids of points [first, last).
  static std::vector<std::int64_t> range(std::int64_t first, std::int64_t last) {
    std::vector<std::int64_t> ids(static_cast<std::size_t>(last - first));
    std::iota(ids.begin(), ids.end(), first);
    return ids;
  }

  static RigidMotion poseOf(int i) {
    return pose({0.02 * i, -0.03 * i, 0.05 * i}, {0.3 * i - 0.3, 0.1 * i, -0.1 * i});
  }

  /// Images 0, 1 and 2: 0 and 1 have 60 points in common, 1 and 2 have 40, 0 and 2 have 20.
  static std::vector<Image> images() {
    const std::vector<std::int64_t> points[] = {range(0, 80), range(20, 100), range(60, 140)};
    std::vector<Image> result;
    for (int i = 0; i < 3; ++i) {
      result.push_back({i + 1, 1, "v/" + std::to_string(i) + ".png", poseOf(i).inverse(), points[i]});
    }
    return result;
  }

  void writeViews(const std::string& scene, const std::vector<double>& distortion = {}) const {
    for (int i = 0; i < 3; ++i) {
      writeView(scene + "/images/v/" + std::to_string(i) + ".png", poseOf(i), distortion);
    }
  }

  PosedPairReader open() const { return PosedPairReader(readColmap("mine", path()), path()); }
};

TEST_F(Colmap, ReadsScenesWithPose) {
  for (const std::string model : {"a/sparse/0", "b/sparse", "c"}) {
    writeViews(model.substr(0, 1));
    model == "b/sparse" ? writeBinary(model, {pinhole()}, images()) : writeText(model, {pinhole()}, images());
  }
  write("other/readme", "");
  EXPECT_TRUE(hasColmap(path()));
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 6u);  // 0 and 2 have 20 points in common, less than 30
  EXPECT_EQ(reader.id(0).text(), "mine/a/v_0-v_1");
  EXPECT_EQ(reader.id(5).text(), "mine/c/v_1-v_2");
  for (std::size_t i = 0; i < 6; ++i) {
    const ImagePair pair = reader.read(i);
    EXPECT_EQ(pair.truth.kind, TruthKind::kFundamental);
    const std::string scene(1, "aabbcc"[i]);
    EXPECT_EQ(pair.left_name, scene + "/images/v/" + std::to_string(i % 2) + ".png");
    EXPECT_EQ(pair.right_name, scene + "/images/v/" + std::to_string(i % 2 + 1) + ".png");
    expectTruth(pair, poseOf(i % 2 == 0 ? 0 : 1));
  }
  EXPECT_LT(cv::norm(reader.read(0).truth.pose->left_camera - camera()), 1e-9);  // half a pixel subtracted
  EXPECT_EQ(reader.ignored(), (std::vector<std::string>{"other"}));
  EXPECT_EQ(reader.files().size(), 3u * (2 + 3));
  EXPECT_EQ(reader.remarks()[0],
            "a: 2 of the 2 pairs of its 3 images that see at least 30 common points are used (min_points, "
            "max_pairs in corrsel.yaml)");
}

TEST_F(Colmap, PairsOfImagesThatDifferInTheirExtensionHaveNamesOfTheirOwn) {
  std::vector<Image> twins = images();
  twins[2].name = "v/1.jpg";
  writeText("a/sparse", {pinhole()}, twins);
  write("corrsel.yaml", "min_points: 20\n");
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 3u);
  EXPECT_EQ(reader.id(0).pair, "v_0-v_1");
  EXPECT_EQ(reader.id(1).pair, "v_0-v_1#2");
  EXPECT_EQ(reader.id(2).pair, "v_1-v_1");
}

TEST_F(Colmap, ImagesFromOnePlaceHaveAHomography) {
  writeViews("a");
  std::vector<Image> turned = images();
  // A place far from the origin, so that its distance to itself is a rounding error.
  turned[0].pose = pose({0.1, 0.2, 0.3}, {100.1, -50.3, 7.7}).inverse();
  turned[1].pose = pose({0.3, 0.1, 0.2}, {100.1, -50.3, 7.7}).inverse();
  ASSERT_GT(cv::norm((turned[1].pose * turned[0].pose.inverse()).translation), 0);
  writeBinary("a/sparse", {pinhole()}, turned);
  const ImagePair pair = open().read(0);
  EXPECT_EQ(pair.truth.kind, TruthKind::kHomography);
  EXPECT_EQ(cv::norm(pair.truth.pose->translation), 0);
}

TEST_F(Colmap, TheRootMayBeTheScene) {
  writeViews(".");
  writeBinary("sparse/0", {pinhole()}, images());
  EXPECT_EQ(open().id(0).sequence, root_.filename().string());
}

TEST_F(Colmap, OptionsChooseThePairs) {
  writeViews("a");
  writeText("a/sparse", {pinhole()}, images());
  write("corrsel.yaml", "min_points: 20\n");
  EXPECT_EQ(open().size(), 3u);
  write("corrsel.yaml", "min_points: 20\nmax_pairs: 2\n");  // of 60, 40 and 20 common points
  const PosedPairReader two = open();
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two.id(0).pair, "v_0-v_1");
  EXPECT_EQ(two.id(1).pair, "v_1-v_2");
  write("corrsel.yaml", "min_points: 200\n");
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { open(); }),
                       "gives no pair: a: 0 of the 0 pairs of its 3 images that see at least 200 common"));
}

TEST_F(Colmap, DistortionIsRemoved) {
  const double fx = camera()(0, 0), fy = camera()(1, 1), cx = camera()(0, 2) + 0.5, cy = camera()(1, 2) + 0.5;
  const struct {
    Camera camera;
    std::vector<double> distortion;
  } lenses[] = {
      {{1, "OPENCV", 4, {fx, fy, cx, cy, -0.2, 0.05, 0.002, -0.001}}, {-0.2, 0.05, 0.002, -0.001}},
      {{1, "FULL_OPENCV", 6, {fx, fy, cx, cy, -0.1, 0.02, 0.001, 0, 0.01, 0.1, 0.01, 0}},
       {-0.1, 0.02, 0.001, 0, 0.01, 0.1, 0.01, 0}},
  };
  for (const auto& lens : lenses) {
    writeViews("a", lens.distortion);
    writeText("a/sparse", {lens.camera}, images());
    const PosedPairReader reader = open();
    const ImagePair pair = reader.read(0);
    expectTruth(pair, poseOf(0));
    EXPECT_EQ(pair.left.size(), cv::Size(kWidth, kHeight));
    ASSERT_EQ(reader.remarks().size(), 2u);
    EXPECT_TRUE(
        contains(reader.remarks()[1], "a: images of camera 1 (320x240 px) are undistorted; their new"));
  }
}

TEST_F(Colmap, CamerasWithOneFocalLength) {
  writeViews("a");
  const struct {
    const char* model;
    std::vector<double> parameters;
    bool distorted;
  } cameras[] = {{"SIMPLE_PINHOLE", {260, 163.5, 117.5}, false},
                 {"SIMPLE_RADIAL", {260, 163.5, 117.5, 0}, false},
                 {"SIMPLE_RADIAL", {260, 163.5, 117.5, -0.1}, true},
                 {"RADIAL", {260, 163.5, 117.5, -0.1, 0.01}, true}};
  for (const auto& camera : cameras) {
    writeText("a/sparse", {{1, camera.model, 0, camera.parameters}}, images());
    const cv::Matx33d k = open().read(0).truth.pose->left_camera;
    EXPECT_EQ(k == cv::Matx33d(260, 0, 163, 0, 260, 117, 0, 0, 1), !camera.distorted) << camera.model << k;
  }
}

TEST_F(Colmap, ImagesOfFisheyeLensesStayRaw) {
  const cv::Vec4d distortion(-0.02, 0.01, 0, 0);
  for (int i = 0; i < 3; ++i) {
    writeFisheyeView("a/images/v/" + std::to_string(i) + ".png", poseOf(i), distortion);
  }
  std::vector<double> parameters = pinhole().parameters;
  parameters.insert(parameters.end(), distortion.val, distortion.val + 4);
  writeBinary("a/sparse/0", {{1, "OPENCV_FISHEYE", 5, parameters}}, images());
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 2u);
  EXPECT_EQ(reader.remarks().size(), 1u) << "nothing is undistorted";
  for (std::size_t i = 0; i < 2; ++i) {
    const ImagePair pair = reader.read(i);
    expectFisheyeTruth(pair, poseOf(static_cast<int>(i)));
    EXPECT_LT(cv::norm(pair.left_camera->matrix - camera()), 1e-9);
    EXPECT_EQ(pair.left_camera->distortion[1], 0.01);
    EXPECT_EQ(pair.right_camera->size, cv::Size(kWidth, kHeight));
  }
}

TEST_F(Colmap, FisheyesFromOnePlaceHaveARotation) {
  std::vector<Image> turned = images();
  turned[0].pose = pose({0, 0.1, 0}, {1, 2, 3}).inverse();
  turned[1].pose = pose({0, -0.1, 0}, {1, 2, 3}).inverse();
  for (int i = 0; i < 3; ++i) writeFisheyeView("a/images/v/" + std::to_string(i) + ".png", poseOf(i), {});
  writeBinary("a/sparse", {{1, "SIMPLE_RADIAL_FISHEYE", 8, {260, 163.5, 117.5, 0.01}}}, turned);
  const ImagePair pair = open().read(0);
  EXPECT_EQ(pair.truth.kind, TruthKind::kRotation);
  EXPECT_EQ(pair.truth.matrix, pair.truth.pose->rotation);
  EXPECT_EQ(pair.left_camera->distortion[0], 0.01);
}

TEST_F(Colmap, PairsHaveTheCamerasOfTheirImages) {
  writeViews("a", {-0.2, 0.05, 0, 0});
  writeText("a/sparse", {{1, "RADIAL", 3, {260, 163.5, 117.5, -0.2, 0.05}}}, images());
  const ImagePair pair = open().read(0);
  ASSERT_TRUE(pair.left_camera && pair.right_camera);
  EXPECT_TRUE(pair.left_camera->isPlainPinhole()) << "the images are undistorted";
  EXPECT_EQ(pair.left_camera->matrix, pair.truth.pose->left_camera);
  EXPECT_EQ(pair.right_camera->size, cv::Size(kWidth, kHeight));
}

TEST_F(Colmap, OtherCamerasAreRefusedByName) {
  writeViews("a");
  writeText("a/sparse", {{1, "FOV", 7, {260, 260, 163, 117, 0.9}}}, images());
  const std::string error = errorOf<DatasetError>([&] { open().check(0); });
  EXPECT_EQ(error.find(path("a/sparse/cameras.txt") + ": line 2: "), 0u) << error;
  EXPECT_TRUE(mentions(error, {"FOV", "OPENCV_FISHEYE", "colmap image_undistorter"})) << error;
  writeText("a/sparse", {{1, "PINHOLE", 1, {260, 163, 117}}}, images());
  EXPECT_TRUE(mentions(errorOf<DatasetError>([&] { open().check(0); }),
                       {"cameras.txt: line 2", "PINHOLE", "3", "4"}));
}

TEST_F(Colmap, FaultsNameWhatIsMissing) {
  writeViews("a");
  std::vector<Image> other_camera = images();
  other_camera[0].camera = 5;
  writeText("a/sparse", {pinhole()}, other_camera);
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { open().check(0); }),
               "images.txt: line 2: the image v/0.png has the camera 5, which the model does not list"));
  EXPECT_NO_THROW(open().read(1));
  writeText("a/sparse", {pinhole()}, images());
  std::filesystem::remove(path("a/images/v/0.png"));
  EXPECT_EQ(errorOf<DatasetError>([&] {
              open().check(0);
            }).find(path("a/images/v/0.png") + ": the image is missing; the images of a model lie in"),
            0u);
  writeImage("a/images/v/0.png");
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { open().read(0); }),
               "0.png: the image has 20x12 px, camera 1 is for 320x240 px; give the image in the size"));
  write("a/sparse/images.txt", "1 2 3\n");
  const PosedPairReader broken = open();
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_EQ(broken.id(0).text(), "mine/a/all");
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { broken.read(0); }), "images.txt: line 1: has 3 entries"));
}

}  // namespace
}  // namespace corrsel::core
