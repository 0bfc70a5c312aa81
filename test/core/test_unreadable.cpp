#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "corrsel/datasets/reader.h"
#include "dataset_folder.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

constexpr const char* kIdentity = "1 0 0 0 1 0 0 0 1";
constexpr const char* kAllLayouts =
    "\nThe folder was searched for"
    "\n  NAME/ with img1..imgN and H1to2p..H1toNp (as in heinly)"
    "\n  NAME/ with 1.ppm..N.ppm and H_1_2..H_1_N (as in hpatches)"
    "\n  NAME/ with 01.png, 02.png and H1to2 (as in symbench)"
    "\n  NAME/ with left.png, right.png and H.txt or F.txt, or matches.csv (as in pairs)"
    "\n  NAME.mat (as in adelaidermf)"
    "\n  1/NAME.png, 2/NAME.png and h/NAME.txt (as in evd)"
    "\n  KIND/SCENE/ with 01.png, 02.png and corrs.txt (as in wxbs)"
    "\n  pairs.txt with lines image_a image_b turns_a turns_b K_a K_b T_ab (as in pair_list)"
    "\n  NAME/sparse/0 (or NAME/sparse) with cameras and images (.bin or .txt) (as in colmap)"
    "\n  NAME/ with rgb.txt and groundtruth.txt (as in tum_rgbd)"
    "\n  NAME/mav0/ with cam0/data.csv and cam0/sensor.yaml (as in euroc)"
    "\nThese layouts are described in docs/datasets.md.";

/// What openDataset() says about folders without a pair that can be read.
class Unreadable : public DatasetFolder {
 protected:
  /// The error of an unknown name without its beginning, which is always the same, and without the layouts.
  std::string cause(const std::string& folder = "") const {
    const std::string error = errorOf<DatasetError>([&] { openDataset("mine", path(folder)); });
    const std::string beginning = "dataset 'mine': '" + path(folder) + "' has no complete pair. ";
    EXPECT_EQ(error.find(beginning), 0u) << error;
    EXPECT_TRUE(contains(error, kAllLayouts)) << error;
    const std::size_t begin = std::min(beginning.size(), error.size());
    return error.substr(begin, error.find("\nThe folder was searched for") - begin);
  }

  void writePair(const fs::path& folder) const {
    writeImage(folder / "left.png");
    writeImage(folder / "right.png");
    write(folder / "H.txt", kIdentity);
  }
};

TEST_F(Unreadable, MissingTruth) {
  for (const fs::path folder : {"a", "b", "c", "d", "e"}) {
    writeImage(folder / "left.png");
    writeImage(folder / "right.png");
  }
  EXPECT_EQ(cause(),
            "The first 3 of its 5 folders, compared with the layout of pairs:\n"
            "  a holds left.png, right.png; H.txt or F.txt is missing\n"
            "  b holds left.png, right.png; H.txt or F.txt is missing\n"
            "  c holds left.png, right.png; H.txt or F.txt is missing");
}

TEST_F(Unreadable, TheLayoutThatFitsBestIsCompared) {
  for (const char* name : {"s/img1.png", "s/img2.png", "s/img3.png", "t/img1.png"}) writeImage(name);
  write("t/notes.txt", "");
  EXPECT_EQ(cause(),
            "Its folders, compared with the layout of heinly:\n"
            "  s holds img1.png, img2.png, img3.png; H1to2p is missing\n"
            "  t holds img1.png, notes.txt; img2 and H1to2p are missing");
}

TEST_F(Unreadable, FlatFiles) {
  for (const char* name : {"a.png", "b.png", "c.png", "d.png", "e.png", "f.png"}) writeImage(name);
  EXPECT_EQ(
      cause(),
      "It holds 6 files (a.png, b.png, c.png, d.png and 2 more) and no folders. Make a folder for each pair, "
      "with left.png, right.png and H.txt or F.txt, or matches.csv.");
}

TEST_F(Unreadable, TypesOfImagesThatAreNotRead) {
  for (const char* name : {"a/left.heic", "a/right.GIF"}) write(name, "");
  write("a/H.txt", kIdentity);
  EXPECT_EQ(cause(),
            "Its folders, compared with the layout of pairs:\n"
            "  a holds H.txt, left.heic, right.GIF; left and right are missing\n"
            "Images of the type .gif and .heic are not read (.ppm, .pgm, .png, .jpg, .jpeg, .bmp, .tif, "
            ".tiff, .webp "
            "are); convert them to PNG.");
  writeImage("b/left.webp");
  writeImage("b/right.webp");
  write("b/H.txt", kIdentity);
  EXPECT_EQ(openDataset("mine", path())->read(1).left.size(), cv::Size(20, 12));
}

TEST_F(Unreadable, EmptyFolders) {
  EXPECT_EQ(cause(), "It is empty.");
  for (const char* folder : {"a", "b"}) fs::create_directories(root_ / folder);
  EXPECT_EQ(cause(), "Its folders, compared with the layout of pairs:\n  a is empty\n  b is empty");
  write("readme.txt", "");
  fs::remove(root_ / "a");
  fs::remove(root_ / "b");
  EXPECT_EQ(cause(), "It holds 1 file (readme.txt) and no folders.");
}

TEST_F(Unreadable, OtherNames) {
  writeImage("a/before.png");
  writeImage("a/behind.png");
  write("a/H.txt", kIdentity);
  EXPECT_EQ(cause(),
            "Its folders, compared with the layout of pairs:\n"
            "  a holds H.txt, before.png, behind.png; left and right are missing\n"
            "Rename the two images of each pair to left and right.");
  EXPECT_EQ(errorOf<DatasetError>([&] { openDataset("pairs", path())->read(0); }),
            path("a") + ": the images before.png, behind.png are neither called left nor right; rename them");
}

TEST_F(Unreadable, OneLevelTooDeep) {
  writePair("mine/desk");
  const std::string expected =
      "It is the folder of one pair (it holds H.txt, left.png, right.png). The dataset is "
      "the folder above it, '" +
      path("mine") + "'.";
  EXPECT_EQ(cause("mine/desk"), expected);
  EXPECT_EQ(cause("mine/desk/").substr(0, 30), expected.substr(0, 30));
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { openDataset("pairs", path("mine/desk")); }), expected));
}

TEST_F(Unreadable, OneLevelTooHigh) {
  writePair("mine/train/desk");
  EXPECT_EQ(cause("mine"), "The pairs lie one folder deeper: the dataset is '" + path("mine/train") + "'.");
  write("mine/adelaide/barrsmith.mat", "");
  EXPECT_EQ(cause("mine"), "The pairs lie one folder deeper: there are several datasets, '" +
                               path("mine/adelaide") + "', '" + path("mine/train") + "'.");
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { openDataset("adelaidermf", path("mine")); }),
                       "The pairs lie one folder deeper"));
}

TEST_F(Unreadable, TheRootOfAllDatasetsIsTheDataset) {
  writePair("mine/desk");
  for (const char* name : {"mine", "pairs", "vgg"}) {
    const std::string missing = path(fs::path("mine") / name);
    EXPECT_EQ(errorOf<DatasetError>([&] { openDataset(name, missing); }),
              std::string("dataset '") + name + "': '" + missing +
                  "' is not a folder. The folder above it, '" + path("mine") +
                  "', is a dataset itself; the folder that holds all datasets (data_root) is '" +
                  root_.string() + "'.");
  }
}

TEST_F(Unreadable, AnotherLayoutThanTheNameStandsFor) {
  writePair("desk");
  const std::string error = errorOf<DatasetError>([&] { openDataset("vgg", path()); });
  EXPECT_EQ(
      error,
      "dataset 'vgg': '" + path() +
          "' has no complete pair. Its folders hold left.png, right.png and H.txt or F.txt, or "
          "matches.csv, which is the layout of pairs. Give the dataset that name, or any other one that "
          "does not stand for a layout.\nThe folder was searched for\n  NAME/ with img1..img6 and "
          "H1to2p..H1to6p (as in vgg)\nThese layouts are described in docs/datasets.md.");
}

}  // namespace
}  // namespace corrsel::core
