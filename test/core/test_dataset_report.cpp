#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "dataset_folder.h"
#include "datasets/dataset_report.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

using Report = DatasetFolder;

TEST_F(Report, TellsWhatIsFoundMissingAndBroken) {
  for (const char* scene : {"bark", "graf"}) {
    for (int k = 1; k <= 6; ++k) {
      const std::string number = std::to_string(k);
      writeImage(fs::path(scene) / ("img" + number + ".ppm"));
      if (k > 1) write(fs::path(scene) / ("H1to" + number + "p"), "1 0 0 0 1 0 0 0 1");
    }
  }
  write("documents/readme", "");
  fs::remove(path("bark/img3.ppm"));
  fs::remove(path("graf/H1to2p"));
  write("graf/H1to6p", "1 0 0 0 1 0 0 0 word");

  const DatasetReport report = describe(*openDataset("vgg", path()), {});
  EXPECT_EQ(report.dataset, "vgg");
  EXPECT_EQ(report.sequences, 2u);
  EXPECT_EQ(report.pairs, 10u);
  EXPECT_EQ(report.missing, (std::vector<std::string>{"bikes", "boat", "leuven", "trees", "ubc", "wall"}));
  EXPECT_EQ(report.ignored, std::vector<std::string>{"documents"});
  ASSERT_EQ(report.problems.size(), 3u);
  EXPECT_TRUE(contains(report.problems[0], "vgg/bark/1-3: " + path("bark/img3") + ": the image is missing"));
  EXPECT_TRUE(contains(report.problems[1], "vgg/graf/1-2: " + path("graf/H1to2p")));
  EXPECT_TRUE(contains(report.problems[2], "'word' is not a number"));

  const std::string text = report.text();
  EXPECT_EQ(text.find("vgg: found 2 sequences, 10 pairs, 3 of them broken\n"), 0u) << text;
  EXPECT_TRUE(contains(text, "missing: 6 of the 8 published sequences: bikes, boat")) << text;
  EXPECT_TRUE(contains(text, "ignored: 1 folder without any file of the layout: documents\n")) << text;
  EXPECT_TRUE(contains(text, "broken: " + report.problems[1] + "\n")) << text;
}

TEST_F(Report, ImagesAreDecodedWherePixelsAreChecked) {
  for (const char* pair : {"cut_off", "empty", "text", "whole"}) {
    writeImage(fs::path(pair) / "left.png", 7);
    writeImage(fs::path(pair) / "right.png", 9);
    write(fs::path(pair) / "H.txt", "1 0 0 0 1 0 0 0 1");
  }
  fs::resize_file(path("cut_off/right.png"), 60);
  write("empty/left.png", "");
  write("text/right.png", "no image");
  EXPECT_TRUE(describe(*openDataset("mine", path()), {}).problems.empty());
  const std::string fault = ": the image cannot be decoded: ";
  EXPECT_EQ(describe(*openDataset("mine", path()), {0, 1, 2, 3}).problems,
            (std::vector<std::string>{
                "mine/cut_off/1-2: " + path("cut_off/right.png") + fault +
                    "the PNG data are cut off after 60 bytes; copy or download the file again",
                "mine/empty/1-2: " + path("empty/left.png") + fault +
                    "the file is empty (0 bytes); copy or download the file again",
                "mine/text/1-2: " + path("text/right.png") + fault +
                    "the file is not an image, it begins with 'no image'; replace it by the image"}));
}

TEST_F(Report, OnlyTheNamedPairsAreDecoded) {
  for (const char* pair : {"a", "b", "c"}) {
    writeImage(fs::path(pair) / "left.png", 7);
    write(fs::path(pair) / "right.png", "no image");
    write(fs::path(pair) / "H.txt", "1 0 0 0 1 0 0 0 1");
  }
  writeImage("b/right.png", 9);
  fs::remove(path("a/left.png"));
  std::vector<std::string> decoded, seen;
  const DatasetReport report = describe(
      *openDataset("mine", path()), {1, 2},
      {[&](const ImagePair& pair) { decoded.push_back(pair.id.sequence); },
       [&](std::size_t done, const PairId& id) { seen.push_back(std::to_string(done) + id.sequence); }});
  EXPECT_EQ(decoded, std::vector<std::string>{"b"});
  EXPECT_EQ(seen, (std::vector<std::string>{"1a", "2b", "3c"}));
  EXPECT_EQ(report.broken, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(report.problems.size(), 2U);
}

TEST(EvenlySpaced, CoversTheWholeRange) {
  EXPECT_EQ(evenlySpaced(3, 5), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(evenlySpaced(10, 5), (std::vector<std::size_t>{0, 2, 4, 6, 8}));
  EXPECT_EQ(evenlySpaced(7, 3), (std::vector<std::size_t>{0, 2, 4}));
  EXPECT_TRUE(evenlySpaced(0, 5).empty() && evenlySpaced(5, 0).empty());
}

TEST_F(Report, WholeDatasetsHaveOneLine) {
  writeImage("s/left.png");
  writeImage("s/right.png");
  write("s/H.txt", "1 0 0 0 1 0 0 0 1");
  EXPECT_EQ(describe(*openDataset("mine", path()), {0}).text(),
            "mine: found 1 sequence, 1 pair, none of them broken\n");
}

TEST_F(Report, BrokenMatFilesDoNotEndIt) {
  write("barrsmith.mat", "no MATLAB file");
  write("sene.mat", "");
  const DatasetReport report = describe(*openDataset("adelaidermf", path()), {});
  EXPECT_EQ(report.problems.size(), 2u);
  EXPECT_EQ(report.missing.size(), 36u);
}

TEST(ReportOfRealData, VggSymbenchAndAdelaideRmf) {
  const struct {
    const char* name;
    std::size_t sequences, pairs;
    std::vector<std::string> missing;
  } cases[] = {{"vgg", 8, 40, {}},
               {"symbench", 46, 46, {}},
               {"adelaidermf", 36, 36, {"johnsona", "johnsonb"}},
               {"adelaidermf_reconstructed", 2, 2, {}}};
  std::size_t seen = 0;
  for (const auto& c : cases) {
    const std::string folder = sharedData(c.name);
    if (folder.empty()) continue;
    ++seen;
    const DatasetReport report = describe(*openDataset(c.name, folder), {});
    EXPECT_EQ(report.sequences, c.sequences) << c.name;
    EXPECT_EQ(report.pairs, c.pairs) << c.name;
    EXPECT_EQ(report.missing, c.missing) << c.name;
    EXPECT_TRUE(report.problems.empty()) << report.text();
    EXPECT_TRUE(report.ignored.empty()) << report.text();
  }
  if (seen == 0) GTEST_SKIP() << "skipped: none of the real datasets is here";
}

}  // namespace
}  // namespace corrsel::core
