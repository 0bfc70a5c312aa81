#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/text.h"
#include "colmap_files.h"
#include "corrsel/datasets/reader.h"
#include "datasets/colmap_model.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class ColmapModelFiles : public ColmapFiles {
 protected:
  const std::vector<Image> images_ = {
      {7, 1, "b/two words.jpg", pose({0.1, 0.2, 0.3}, {1, 2, 3}), {5, -1, 3, 5}},
      {9, 1, "a.jpg", pose({0, 0, 0}, {0, 0, 0}), {}},
      {11, 2, "c.jpg", pose({1, 0, 0}, {0, 1, 0}), {3}}};
  const std::vector<Camera> cameras_ = {pinhole(),
                                        {2, "FULL_OPENCV", 6, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}}};

  std::string errorHere() const {
    return errorOf<DatasetError>([&] { readColmapModel(path()); });
  }
};

TEST_F(ColmapModelFiles, TextAndBinaryAreTheSame) {
  for (const bool binary : {false, true}) {
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
    EXPECT_FALSE(hasColmapModel(path()));
    binary ? writeBinary(".", cameras_, images_) : writeText(".", cameras_, images_);
    EXPECT_TRUE(hasColmapModel(path()));
    const ColmapModel model = readColmapModel(path());
    ASSERT_EQ(model.cameras.size(), 2u);
    EXPECT_EQ(model.cameras[0].camera.model, "PINHOLE");
    EXPECT_EQ(model.cameras[0].camera.size, cv::Size(320, 240));
    EXPECT_EQ(model.cameras[0].camera.parameters, (std::vector<double>{260, 255, 163.5, 117.5}));
    EXPECT_EQ(model.cameras[1].id, 2);
    EXPECT_EQ(model.cameras[1].camera.parameters.size(), 12u);
    ASSERT_EQ(model.images.size(), 3u);
    EXPECT_EQ(model.images[0].name, "b/two words.jpg");
    EXPECT_EQ(model.images[0].id, 7);
    EXPECT_EQ(model.images[0].points, (std::vector<std::int64_t>{3, 5}));
    EXPECT_LT(cv::norm(model.images[0].pose.rotation - images_[0].pose.rotation), 1e-5);
    EXPECT_EQ(model.images[0].pose.translation, cv::Vec3d(1, 2, 3));
    EXPECT_TRUE(model.images[1].points.empty());
    EXPECT_EQ(model.images[2].camera, 2);
    EXPECT_EQ(colmapFiles(path())[1], path(binary ? "images.bin" : "images.txt"));
  }
}

TEST_F(ColmapModelFiles, FaultsOfTextNameTheLine) {
  writeText(".", cameras_, images_);
  EXPECT_EQ(errorHere(), "");
  write("cameras.txt", "1 PINHOLE 320\n");
  EXPECT_EQ(errorHere().find(path("cameras.txt") + ": line 1: has 3 entries, at least 4 are expected"), 0u);
  write("cameras.txt", "1 PINHOLE 320 tall 1 2 3 4\n");
  EXPECT_EQ(errorHere().find(path("cameras.txt") + ": line 1: entry 4: 'tall'"), 0u) << errorHere();
  write("cameras.txt", "1 PINHOLE 0 240 1 2 3 4\n");
  EXPECT_TRUE(contains(errorHere(), "line 1: the size of the images, 0x240, is not one of 1 to"));
  writeText(".", cameras_, images_);
  const std::string images = path("images.txt") + ": ";
  write("images.txt", "# head\n1 1 0 0 0 0 0 0 1\n\n");
  EXPECT_EQ(errorHere().find(images + "line 2: has 9 entries, at least 10 are expected"), 0u) << errorHere();
  write("images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n1 2\n");
  EXPECT_EQ(errorHere().find(images + "line 2: has 2 entries, which is no multiple of 3"), 0u);
  write("images.txt", "1 0 0 0 0 0 0 0 1 a.jpg\n\n");
  EXPECT_EQ(errorHere().find(images + "line 1: the quaternion is 0 0 0 0"), 0u);
  write("images.txt", "1.5 1 0 0 0 0 0 0 1 a.jpg\n\n");
  EXPECT_EQ(errorHere().find(images + "line 1: entry 1: '1.5' is not a whole number"), 0u);
  write("images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n1 2 1e300\n");
  EXPECT_EQ(errorHere().find(images + "line 2: entry 3: '1e300' is not a whole number up to 2^53"), 0u);
}

TEST_F(ColmapModelFiles, FaultsOfBinaryNameTheFile) {
  writeBinary(".", cameras_, images_);
  const std::string cameras = readTextFile(path("cameras.bin")), images = readTextFile(path("images.bin"));
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, std::size_t{40}, images.size() - 1}) {
    write("images.bin", images.substr(0, length));
    EXPECT_EQ(errorHere().find(path("images.bin") + ": is cut off or not of COLMAP's binary format"), 0u)
        << length;
  }
  write("images.bin", std::string(200, '\xff'));
  EXPECT_EQ(errorHere().find(path("images.bin") + ": is cut off or not"), 0u);
  std::string unknown = cameras;
  unknown[12] = 99;
  write("cameras.bin", unknown);
  EXPECT_TRUE(contains(errorHere(), "cameras.bin: camera 1 has the model number 99, which is not known"));
  write("cameras.bin", cameras);
  std::vector<Image> undefined = images_;
  undefined[0].pose.translation[1] = NAN;
  writeBinary(".", cameras_, undefined);
  EXPECT_EQ(errorHere().find(path("images.bin") + ": image 7: the translation is 1 nan 3, which is not"), 0u)
      << errorHere();
  std::string turned = images;
  turned.replace(8 + 4, 4 * sizeof(double), 4 * sizeof(double), '\xff');  // NaN
  write("images.bin", turned);
  EXPECT_TRUE(contains(errorHere(), "which is no rotation; export the model again")) << errorHere();
  std::filesystem::remove_all(path("images.bin"));
  EXPECT_TRUE(contains(errorHere(), "cameras.txt: the file is missing"));
}

}  // namespace
}  // namespace corrsel::core
