#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "dataset_folder.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

constexpr const char* kIdentity = "1 0 0 0 1 0 0 0 1";

class OpenDataset : public DatasetFolder {
 protected:
  /// Writes three files of a pair below `folder`.
  void writePair(const std::string& folder, const std::string& left, const std::string& right,
                 const std::string& homography, const std::string& text = kIdentity) const {
    writeImage(fs::path(folder) / left);
    writeImage(fs::path(folder) / right);
    write(fs::path(folder) / homography, text);
  }

  std::string errorFor(const std::string& name) const {
    return errorOf<DatasetError>([&] { openDataset(name, path()); });
  }
};

TEST_F(OpenDataset, KnowsItsNames) {
  EXPECT_EQ(datasetNames(),
            (std::vector<std::string>{"adelaidermf", "adelaidermf_reconstructed", "calibrated30_generated",
                                      "calibrated70_generated", "calibrated95_generated", "colmap", "euroc",
                                      "evd", "heinly", "heinly_generated", "hpatches", "pair_list", "pairs",
                                      "sample", "symbench", "tum_rgbd", "vgg", "wxbs"}));
  for (const std::string& name : datasetNames()) {
    EXPECT_EQ(needsSamplePhotographs(name), name == "sample" || name == "heinly_generated") << name;
    if (!needsFolder(name)) {
      EXPECT_GT(openDataset(name, path("nowhere"))->size(), 0u);
      continue;
    }
    const std::string error = errorOf<DatasetError>([&] { openDataset(name, path("nowhere")); });
    EXPECT_TRUE(contains(error, "'" + path("nowhere") + "' is not a folder")) << error;
  }
  EXPECT_FALSE(needsSamplePhotographs("mine"));
  EXPECT_TRUE(needsSamplePhotographs("unrelated_sample"));
  EXPECT_FALSE(needsSamplePhotographs("unrelated_vgg"));
}

TEST_F(OpenDataset, OpensKnownNamesInTheirLayout) {
  writePair("vgg/s", "img1.ppm", "img2.ppm", "H1to2p");
  writePair("heinly/s", "img1.ppm", "img2.ppm", "H1to2p");
  writePair("hpatches/s", "1.ppm", "2.ppm", "H_1_2");
  writePair("symbench/s", "01.png", "02.png", "H1to2");
  writePair("pairs/s", "left.png", "right.png", "H.txt");
  EXPECT_EQ(openDataset("vgg", path("vgg"))->size(), 5u);
  for (const char* name : {"vgg", "heinly", "hpatches", "symbench", "pairs"}) {
    const auto reader = openDataset(name, path(name));
    EXPECT_EQ(reader->id(0).text(), std::string(name) + "/s/1-2");
    EXPECT_NO_THROW(reader->read(0));
    const std::string error = errorOf<DatasetError>([&] { openDataset(name, path()); });
    EXPECT_TRUE(contains(error, "The pairs lie one folder deeper")) << error;
  }
}

TEST_F(OpenDataset, RecognisesTheLayoutOfOtherNames) {
  const struct {
    const char* left;
    const char* right;
    const char* truth;
  } layouts[] = {{"img1.png", "img2.png", "H1to2p"},
                 {"1.ppm", "2.png", "H_1_2"},
                 {"01.png", "02.png", "H1to2"},
                 {"left.jpg", "right.png", "H.txt"},
                 {"left.webp", "right.png", "F.txt"}};
  for (const auto& layout : layouts) {
    fs::remove_all(root_);
    const bool fundamental = layout.truth == std::string("F.txt");
    writePair("scene", layout.left, layout.right, layout.truth,
              fundamental ? "0 0 0 0 0 -1 0 1 0" : kIdentity);
    write("other/readme", "");
    const auto reader = openDataset("mine", path());
    ASSERT_EQ(reader->size(), 1u);
    EXPECT_EQ(reader->id(0).text(), "mine/scene/1-2");
    EXPECT_NO_THROW(reader->read(0));
    // A bad matrix is the pair's fault, not the layout's.
    write(fs::path("scene") / layout.truth, "seven");
    EXPECT_THROW(openDataset("mine", path())->read(0), DatasetError);
  }
}

TEST_F(OpenDataset, RecognisesMatchLists) {
  write("scene/matches.csv", "x_left,y_left,x_right,y_right,label\n1,2,3,4,1\n");
  const auto reader = openDataset("mine", path());
  ASSERT_EQ(reader->size(), 1u);
  EXPECT_EQ(reader->read(0).given->size(), 1u);
  EXPECT_EQ(reader->read(0).truth.kind, TruthKind::kLabels);
}

TEST_F(OpenDataset, RecognisesLayoutsOfWholeFolders) {
  const struct {
    const char* name;
    std::vector<std::string> files;  ///< that tell the layout
  } layouts[] = {{"evd", {"1/a.png", "2/a.png", "h/a.txt"}},
                 {"wxbs", {"WGABS/s/01.png", "WGABS/s/02.png", "WGABS/s/corrs.txt"}},
                 {"pair_list", {"pairs.txt"}},
                 {"colmap", {"s/sparse/0/cameras.txt", "s/sparse/0/images.txt"}},
                 {"tum_rgbd", {"s/rgb.txt", "s/groundtruth.txt"}},
                 {"euroc", {"s/mav0/cam0/data.csv"}}};
  for (const auto& layout : layouts) {
    fs::remove_all(root_);
    fs::create_directories(root_);
    const std::string error = errorOf<DatasetError>([&] { openDataset(layout.name, path()); });
    EXPECT_TRUE(contains(error, "has no complete pair. It is empty.")) << error;
    EXPECT_TRUE(contains(error, std::string(" (as in ") + layout.name + ")")) << error;
    for (const std::string& file : layout.files) write(file, "a.png b.png 1");
    for (const std::string& name : {std::string(layout.name), std::string("mine")}) {
      // Whatever is wrong with the files is said about the pair.
      const auto reader = openDataset(name, path());
      ASSERT_EQ(reader->size(), 1u) << name;
      EXPECT_EQ(reader->id(0).dataset, name);
      EXPECT_THROW(reader->read(0), DatasetError);
      EXPECT_FALSE(reader->files().empty() && layout.files.size() > 1);
    }
    const std::string other = errorOf<DatasetError>([&] { openDataset("adelaidermf", path()); });
    EXPECT_TRUE(contains(other, std::string(", which is the layout of ") + layout.name + ". Give")) << other;
  }
}

TEST_F(OpenDataset, AFolderOfDatasetsIsNotTakenForOneOfTheirs) {
  write("room/rgb.txt", "");
  write("room/groundtruth.txt", "");
  const std::string error = errorOf([&] { openDataset("vgg", path("vgg")); });
  EXPECT_TRUE(contains(error, "'" + path() + "' holds the folders room")) << error;
  EXPECT_FALSE(contains(error, "is a dataset itself")) << error;
}

TEST_F(OpenDataset, UnrelatedPairsNeedImages) {
  for (const std::string scene : {"desk", "wall"}) {
    write(scene + "/matches.csv", "x_left,y_left,x_right,y_right,label\n1,2,3,4,1\n");
  }
  const auto reader = openDataset("unrelated_mine", path());
  const std::string error = errorOf<DatasetError>([&] { reader->read(0); });
  EXPECT_TRUE(contains(error, "mine/desk/1-2 has no images")) << error;
}

TEST_F(OpenDataset, MakesUnrelatedPairsOfAnyDataset) {
  for (const char* scene : {"pairs/desk", "pairs/wall"}) writePair(scene, "left.png", "right.png", "H.txt");
  for (const char* name : {"pairs", "mine"}) {
    const auto reader = openDataset(std::string("unrelated_") + name, path("pairs"));
    ASSERT_EQ(reader->size(), 2u);
    EXPECT_EQ(reader->id(0).dataset, std::string("unrelated_") + name);
    EXPECT_EQ(reader->read(0).left.size(), cv::Size(20, 12));
    EXPECT_TRUE(isUnrelated(reader->id(0).dataset));
    EXPECT_EQ(imageDataset(reader->id(0).dataset), name);
  }
  EXPECT_FALSE(isUnrelated("vgg"));
  EXPECT_EQ(imageDataset("vgg"), "vgg");
  const std::string error = errorOf<std::invalid_argument>([&] { openDataset("unrelated_", path("pairs")); });
  EXPECT_TRUE(contains(error, "dataset name ''")) << error;
}

TEST_F(OpenDataset, RefusesToGuessBetweenLayouts) {
  writePair("a", "left.png", "right.png", "H.txt");
  writePair("b", "1.png", "2.png", "H_1_2");
  EXPECT_TRUE(contains(errorFor("mine"), "holds several layouts")) << errorFor("mine");
}

TEST_F(OpenDataset, UnknownNameWithoutFolderListsTheKnownOnes) {
  const std::string error = errorOf<std::invalid_argument>([&] { openDataset("vg", path("vg")); });
  EXPECT_TRUE(contains(error, "unknown dataset 'vg'")) << error;
  EXPECT_TRUE(
      contains(error, "known datasets: adelaidermf, adelaidermf_reconstructed, calibrated30_generated"))
      << error;
  EXPECT_TRUE(contains(error, "any other folder must have one of the layouts")) << error;
  write("file", "");
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { openDataset("file", path("file")); }),
                       "'" + path("file") + "' is not a folder"));
}

TEST_F(OpenDataset, MisspeltNamesAreToldWithTheFoldersThereAre) {
  for (const char* folder : {"vgg/graf", "my_pairs/s", "VFC"}) fs::create_directories(path(folder));
  const auto errorOfName = [&](const std::string& name) {
    return errorOf([&] { openDataset(name, path(name)); });
  };
  const std::string holds = "'" + path() + "' holds the folders VFC, my_pairs, vgg";
  EXPECT_EQ(
      errorOfName("vgf").find("unknown dataset 'vgf': '" + path("vgf") +
                              "' is not a folder; did you mean 'vgg'? " + holds + "; known datasets: adel"),
      0U)
      << errorOfName("vgf");
  // Of the folders first, then of the known names.
  EXPECT_TRUE(contains(errorOfName("mypairs"), "did you mean 'my_pairs'?")) << errorOfName("mypairs");
  EXPECT_TRUE(contains(errorOfName("sampel"), "did you mean 'sample'?")) << errorOfName("sampel");
  EXPECT_FALSE(contains(errorOfName("nonsense"), "did you mean")) << errorOfName("nonsense");
  // A known name has no folder: only folders can be meant.
  EXPECT_EQ(errorOfName("hpatches"),
            "dataset 'hpatches': '" + path("hpatches") + "' is not a folder; " + holds);
  EXPECT_TRUE(contains(errorOfName("unrelated_vgf"), "dataset 'vgf'")) << errorOfName("unrelated_vgf");
  for (int k = 10; k < 40; ++k) fs::create_directories(path("a" + std::to_string(k)));
  EXPECT_TRUE(contains(errorOfName("vgf"), "VFC, a10, ")) << errorOfName("vgf");
  EXPECT_TRUE(contains(errorOfName("vgf"), "a28 and 13 more; known")) << errorOfName("vgf");
}

TEST_F(OpenDataset, FoldersThatCannotHoldDatasetsAreNamed) {
  const auto errorAt = [](const std::string& name, const std::string& folder) {
    return errorOf([&] { openDataset(name, folder); });
  };
  EXPECT_EQ(errorAt("vgg", path("dta/vgg")), "dataset 'vgg': '" + path("dta/vgg") + "' is not a folder; '" +
                                                 path("dta") +
                                                 "' does not exist: give the folder that holds one folder "
                                                 "per dataset");
  write("file", "");
  EXPECT_TRUE(contains(errorAt("vgg", path("file/vgg")), "'" + path("file") + "' is a file: give the folder"))
      << errorAt("vgg", path("file/vgg"));
  fs::create_directories(path("empty"));
  EXPECT_TRUE(contains(errorAt("mine", path("empty/mine")), "'" + path("empty") + "' holds no folder; known"))
      << errorAt("mine", path("empty/mine"));
  // The folder of the dataset in place of the folder that holds it, told by its name.
  fs::create_directories(path("vgg"));
  const std::string by_name = errorAt("vgg", path("vgg/vgg"));
  EXPECT_TRUE(contains(by_name, "'" + path("vgg") +
                                    "' seems to be a dataset itself: give the folder that holds "
                                    "it, '" +
                                    path() + "'"))
      << by_name;
}

TEST_F(OpenDataset, NamesMustStayInsideTheDataRoot) {
  writePair("s", "left.png", "right.png", "H.txt");
  for (const char* name : {"", ".", "..", "../x", "a/b", "/etc", "a\\b", "pairs/"}) {
    const std::string error = errorOf<std::invalid_argument>([&] { openDataset(name, path()); });
    EXPECT_TRUE(contains(error, std::string("dataset name '") + name + "' must be the plain name")) << error;
  }
}

TEST_F(OpenDataset, OddNamesComeThroughUnharmed) {
  writePair("s", "left.png", "right.png", "H.txt");
  for (const char* name : {"my pairs", "a,b", "\"quoted\"", "it's", "<b>bold", "two\nlines", "a..b"}) {
    EXPECT_EQ(openDataset(name, path())->id(0).dataset, name);
  }
}

}  // namespace
}  // namespace corrsel::core
