#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "datasets/homography_pairs.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

HomographyPairReader openVgg(const std::string& folder) { return {"vgg", folder, HomographyLayout::kVgg}; }

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

/// A folder with the scenes "one" (ppm, colour) and "two" (pgm, grey), removed at the end.
class VggFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_vgg_" + std::to_string(::getpid()));
    fs::remove_all(root_);
    for (const char* scene : {"two", "one"}) {
      fs::create_directories(root_ / scene);
      const bool colour = std::string(scene) == "one";
      for (int i = 1; i <= 6; ++i) {
        const cv::Mat image(12, 20, colour ? CV_8UC3 : CV_8UC1, cv::Scalar(i, 2 * i, 3 * i));
        cv::imwrite((root_ / scene / ("img" + std::to_string(i) + (colour ? ".ppm" : ".pgm"))).string(),
                    image);
        if (i > 1) {
          write(root_ / scene / ("H1to" + std::to_string(i) + "p"),
                "1 0 " + std::to_string(i) + "\n0 1 0\n0 1e-4 1\n");
        }
      }
    }
  }

  void TearDown() override { fs::remove_all(root_); }

  /// Reads pair `index`, which must fail, while all others must not.
  std::string onlyErrorAt(std::size_t index) const {
    const HomographyPairReader reader = openVgg(root_.string());
    for (std::size_t i = 0; i < reader.size(); ++i) {
      if (i != index) {
        EXPECT_NO_THROW(reader.read(i)) << reader.id(i).text();
      }
    }
    return errorOf<DatasetError>([&] { reader.read(index); });
  }

  fs::path root_;
};

TEST_F(VggFolder, GivesFivePairsPerSceneInAlphabeticalOrder) {
  const HomographyPairReader reader = openVgg(root_.string());
  ASSERT_EQ(reader.size(), 10u);
  EXPECT_EQ(reader.id(0).text(), "vgg/one/1-2");
  EXPECT_EQ(reader.id(4).text(), "vgg/one/1-6");
  EXPECT_EQ(reader.id(9).text(), "vgg/two/1-6");
  EXPECT_EQ(reader.files().size(), 2u * (6 + 5));

  const ImagePair pair = reader.read(3);
  EXPECT_EQ(pair.id, reader.id(3));
  EXPECT_EQ(pair.left.type(), CV_8UC3);
  EXPECT_EQ(pair.right.at<cv::Vec3b>(0, 0), cv::Vec3b(5, 10, 15));
  EXPECT_EQ(pair.truth.kind, TruthKind::kHomography);
  EXPECT_EQ(pair.truth.matrix, cv::Matx33d(1, 0, 5, 0, 1, 0, 0, 1e-4, 1));
  EXPECT_FALSE(pair.given.has_value());
  EXPECT_EQ(reader.read(9).left.type(), CV_8UC1);
}

TEST_F(VggFolder, IsFoundByName) {
  EXPECT_EQ(openDataset("vgg", root_.string())->size(), 10u);
  // Images and homographies beyond the sixth are not the dataset's.
  write(root_ / "one" / "H1to7p", "1 0 0 0 1 0 0 0 1");
  EXPECT_EQ(openDataset("vgg", root_.string())->size(), 10u);
}

TEST_F(VggFolder, RefusesMissingAndEmptyFolders) {
  const std::string missing = (root_ / "nowhere").string();
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { openVgg(missing); }), missing));
  fs::create_directories(root_ / "empty" / "scene");
  const std::string error = errorOf<DatasetError>([&] { openDataset("vgg", (root_ / "empty").string()); });
  EXPECT_TRUE(contains(error, "empty' has no complete pair")) << error;
  EXPECT_TRUE(contains(error, "NAME/ with img1..img6")) << error;
}

TEST_F(VggFolder, NamesTheMissingImage) {
  fs::remove(root_ / "one" / "img3.ppm");
  const std::string error = onlyErrorAt(1);
  EXPECT_TRUE(contains(error, (root_ / "one" / "img3").string())) << error;
  EXPECT_TRUE(contains(error, "missing")) << error;
}

TEST_F(VggFolder, NamesTheUnreadableImage) {
  fs::resize_file(root_ / "two" / "img6.pgm", 5);
  const std::string error = onlyErrorAt(9);
  EXPECT_TRUE(contains(error, (root_ / "two" / "img6.pgm").string())) << error;
  EXPECT_TRUE(contains(error, "cannot be decoded")) << error;
}

TEST_F(VggFolder, NamesTheMissingHomography) {
  fs::remove(root_ / "two" / "H1to2p");
  const std::string error = onlyErrorAt(5);
  EXPECT_TRUE(contains(error, (root_ / "two" / "H1to2p").string())) << error;
  EXPECT_TRUE(contains(error, "missing")) << error;
}

TEST_F(VggFolder, RefusesBadHomographies) {
  const struct {
    const char* text;
    const char* expected;
  } cases[] = {
      {"1 0 0\n0 1 0\n0\n", "holds 7 numbers"},
      {"", "holds 0 numbers"},
      {"1 0 0 0 1 0 0 0 1 1", "more than the 9"},
      {"1 0 0 0 one 0 0 0 1", "'one' is not a number"},
      {"1 0 0 0 inf 0 0 0 1", "not finite"},
      {"0 0 0 0 0 0 0 0 0", "singular"},
      {"1 2 300 2 4 600 0 0 1", "is singular; "},
      {"0.9 0.1 0 -0.1 0.9 0 250 -180 1", "singular, but its transpose is not: the numbers are probably"},
  };
  for (const auto& c : cases) {
    write(root_ / "one" / "H1to4p", c.text);
    const std::string error = onlyErrorAt(2);
    EXPECT_TRUE(contains(error, (root_ / "one" / "H1to4p").string())) << error;
    EXPECT_TRUE(contains(error, c.expected)) << error;
  }
}

TEST(Vgg, ReadsTheRealDataset) {
  const std::string folder = sharedData("vgg");
  if (folder.empty()) GTEST_SKIP() << "skipped: the VGG images are not here";
  const HomographyPairReader reader = openVgg(folder);
  ASSERT_EQ(reader.size(), 40u);
  std::set<std::string> sequences;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    sequences.insert(pair.id.sequence);
    ASSERT_FALSE(pair.left.empty() || pair.right.empty()) << pair.id.text();
    // The JPEG scene is the only one whose camera stood still.
    EXPECT_EQ(pair.truth.matrix == cv::Matx33d::eye(), pair.id.sequence == "ubc") << pair.id.text();
  }
  EXPECT_EQ(sequences,
            (std::set<std::string>{"bark", "bikes", "boat", "graf", "leuven", "trees", "ubc", "wall"}));
}

}  // namespace
}  // namespace corrsel::core
