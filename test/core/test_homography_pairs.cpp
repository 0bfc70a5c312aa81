#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset_folder.h"
#include "datasets/homography_pairs.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

using HomographyPairs = DatasetFolder;

std::vector<std::string> idsOf(const DatasetReader& reader) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < reader.size(); ++i) ids.push_back(reader.id(i).text());
  return ids;
}

/// A pure change of scale and rotation about the origin.
std::string similarityText(double scale, double degrees) {
  const double c = scale * std::cos(degrees * CV_PI / 180), s = scale * std::sin(degrees * CV_PI / 180);
  return std::to_string(c) + " " + std::to_string(-s) + " 0\n" + std::to_string(s) + " " + std::to_string(c) +
         " 0\n0 0 1\n";
}

// The images of the Heinly dataset are not at hand: scenes of pure zoom and pure rotation in its layout.
TEST_F(HomographyPairs, ReadsHeinlyScenesOfAnyNumberOfImages) {
  for (int k = 1; k <= 12; ++k) {
    const std::string number = std::to_string(k);
    writeImage("zoom/img" + number + ".png", k);
    if (k > 1) write("zoom/H1to" + number + "p", similarityText(1 + 0.25 * k, 0));
  }
  for (int k = 1; k <= 3; ++k) {
    const std::string number = std::to_string(k);
    writeImage("rotation/img" + number + ".jpg", 10 * k);
    if (k > 1) write("rotation/H1to" + number + "p", similarityText(1, 30 * k));
  }
  const HomographyPairReader reader("heinly", path(), HomographyLayout::kNumbered);
  EXPECT_EQ(idsOf(reader),
            (std::vector<std::string>{
                "heinly/rotation/1-2", "heinly/rotation/1-3", "heinly/zoom/1-2", "heinly/zoom/1-3",
                "heinly/zoom/1-4", "heinly/zoom/1-5", "heinly/zoom/1-6", "heinly/zoom/1-7", "heinly/zoom/1-8",
                "heinly/zoom/1-9", "heinly/zoom/1-10", "heinly/zoom/1-11", "heinly/zoom/1-12"}));
  EXPECT_EQ(reader.files().size(), 3u + 2u + 12u + 11u);
  const ImagePair zoom = reader.read(12);
  EXPECT_EQ(zoom.left.data[0], 1);
  EXPECT_EQ(zoom.right.data[0], 12);
  EXPECT_EQ(zoom.left_name, "zoom/img1.png");
  EXPECT_EQ(zoom.right_name, "zoom/img12.png");
  EXPECT_EQ(zoom.truth.matrix, cv::Matx33d(4, 0, 0, 0, 4, 0, 0, 0, 1));
  const cv::Matx33d rotation = reader.read(1).truth.matrix;
  EXPECT_NEAR(rotation(0, 1), -1, 1e-6);
  EXPECT_NEAR(rotation(1, 0), 1, 1e-6);
  EXPECT_THROW(reader.id(13), std::out_of_range);
  EXPECT_THROW(reader.check(13), std::out_of_range);
}

TEST_F(HomographyPairs, GapsCostTheirPairOnly) {
  for (const int k : {1, 2, 4}) writeImage("s/img" + std::to_string(k) + ".pgm");
  for (const int k : {2, 3, 5}) write("s/H1to" + std::to_string(k) + "p", "1 0 0 0 1 0 0 0 1");
  const HomographyPairReader reader("heinly", path(), HomographyLayout::kNumbered);
  ASSERT_EQ(reader.size(), 4u);  // image 4 has no homography, homography 5 no image
  EXPECT_NO_THROW(reader.read(0));
  const std::string expected[] = {"", "s/img3: the image is missing", "s/H1to4p: the homography is missing",
                                  "s/img5: the image is missing"};
  for (std::size_t i = 1; i < 4; ++i) {
    const std::string error = errorOf<DatasetError>([&] { reader.read(i); });
    EXPECT_TRUE(contains(error, path(expected[i]))) << error;
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(i); }), error);
  }
}

TEST_F(HomographyPairs, ASceneOfOneImageIsABrokenPair) {
  writeImage("s/img1.png");
  const HomographyPairReader reader("heinly", path(), HomographyLayout::kNumbered);
  ASSERT_EQ(reader.size(), 1u);
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { reader.read(0); }), "s/img2: the image is missing"));
}

TEST_F(HomographyPairs, ReadsHpatches) {
  for (int k = 1; k <= 6; ++k) {
    const std::string number = std::to_string(k);
    writeImage("v_wall/" + number + ".ppm", k);
    writeImage("i_lamp/" + number + ".ppm", 10 + k);
    for (const char* sequence : {"v_wall/H_1_", "i_lamp/H_1_"}) {
      if (k > 1) write(sequence + number, "1 0 " + number + "\n0 1 0\n0 0 1\n");
    }
  }
  // None of these is an image's number.
  for (const char* name :
       {"v_wall/0.ppm", "v_wall/08.ppm", "v_wall/20240101.ppm", "v_wall/9.txt", "v_wall/H_1_7x"})
    write(name, "");
  const HomographyPairReader reader("hpatches", path() + "/", HomographyLayout::kHpatches);
  ASSERT_EQ(reader.size(), 10u);
  EXPECT_EQ(reader.id(0).text(), "hpatches/i_lamp/1-2");
  const ImagePair pair = reader.read(9);
  EXPECT_EQ(pair.id.text(), "hpatches/v_wall/1-6");
  EXPECT_EQ(pair.left.data[0], 1);
  EXPECT_EQ(pair.right.data[0], 6);
  EXPECT_EQ(pair.truth.matrix(0, 2), 6);
}

TEST_F(HomographyPairs, HpatchesHas580Pairs) {
  const auto folderOf = [](int k) { return (k < 57 ? "i_scene" : "v_scene") + std::to_string(k); };
  writeImage("1.ppm");
  for (int k = 0; k < 116; ++k) {
    write(folderOf(k) + "/H_1_2", "1 0 0 0 1 0 0 0 1");
    for (int number = 1; number <= 6; ++number) {
      const std::string image = folderOf(k) + "/" + std::to_string(number) + ".ppm";
      fs::create_hard_link(root_ / "1.ppm", root_ / image);
      if (number > 1) write(folderOf(k) + "/H_1_" + std::to_string(number), "1 0 0 0 1 0 0 0 1");
    }
  }
  fs::remove(root_ / "1.ppm");
  const HomographyPairReader reader("hpatches", path(), HomographyLayout::kHpatches);
  ASSERT_EQ(reader.size(), 580u);
  for (std::size_t i = 0; i < reader.size(); ++i) EXPECT_NO_THROW(reader.check(i));
}

TEST_F(HomographyPairs, TwoFilesForOneImageAreRefused) {
  const struct {
    HomographyLayout layout;
    const char *left, *right, *homography;
  } layouts[] = {{HomographyLayout::kVgg, "img1", "img2", "H1to2p"},
                 {HomographyLayout::kNumbered, "img1", "img2", "H1to2p"},
                 {HomographyLayout::kHpatches, "1", "2", "H_1_2"},
                 {HomographyLayout::kSymbench, "01", "02", "H1to2"}};
  for (const auto& layout : layouts) {
    fs::remove_all(root_);
    const fs::path scene = "s";
    const std::string left = layout.left, right = layout.right;
    for (const std::string& image : {left + ".png", left + ".JPG", right + ".png"}) writeImage(scene / image);
    write(scene / layout.homography, "1 0 0 0 1 0 0 0 1");
    const HomographyPairReader reader("mine", path(), layout.layout);
    const std::string error = errorOf<DatasetError>([&] { reader.read(0); });
    EXPECT_EQ(error,
              path(scene / left) + ": " + left + ".JPG and " + left +
                  ".png are several files for one image; keep the one to which the ground truth belongs");
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(0); }), error);
    EXPECT_EQ(reader.files().size(), 4u);
  }
}

}  // namespace
}  // namespace corrsel::core
