#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "datasets/homography_pairs.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

HomographyPairReader openSymbench(const std::string& folder) {
  return {"symbench", folder, HomographyLayout::kSymbench};
}

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

/// A folder with the pairs "a", "b" and "c", removed at the end. Beside them lies what is no pair.
class SymbenchFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_symbench_" + std::to_string(::getpid()));
    fs::remove_all(root_);
    for (const char* name : {"c", "a", "b"}) {
      const double value = 10.0 * name[0];
      fs::create_directories(root_ / name);
      cv::imwrite((root_ / name / "01.png").string(), cv::Mat(12, 20, CV_8UC1, cv::Scalar(value / 10)));
      cv::imwrite((root_ / name / "02.png").string(), cv::Mat(14, 22, CV_8UC3, cv::Scalar(1, 2, value / 10)));
      // As some files of the dataset are written.
      write(root_ / name / "H1to2", "    1.0e+000   -2.5E-1  " + std::to_string(value) +
                                        "  \n 121.5e-003 1  -7 \n 1.1E-4 0  1.0  \n\n");
    }
    fs::create_directories(root_ / "unrelated");
    write(root_ / "README", "not a pair");
  }

  void TearDown() override { fs::remove_all(root_); }

  /// Reads pair "b", which must fail, while the others must not.
  std::string onlyErrorAtB() const {
    const HomographyPairReader reader = openSymbench(root_.string());
    EXPECT_EQ(reader.size(), 3u);
    EXPECT_NO_THROW(reader.read(0));
    EXPECT_NO_THROW(reader.read(2));
    return errorOf<DatasetError>([&] { reader.read(1); });
  }

  fs::path root_;
};

TEST_F(SymbenchFolder, GivesOnePairPerFolderInAlphabeticalOrder) {
  const HomographyPairReader reader = openSymbench(root_.string());
  ASSERT_EQ(reader.size(), 3u);
  EXPECT_EQ(reader.id(0).text(), "symbench/a/1-2");
  EXPECT_EQ(reader.id(2).text(), "symbench/c/1-2");
  EXPECT_THROW(reader.id(3), std::out_of_range);
  EXPECT_EQ(reader.files().size(), 9u);
  EXPECT_EQ(reader.files().front(), (root_ / "a" / "01.png").string());

  const ImagePair pair = reader.read(1);
  EXPECT_EQ(pair.id, reader.id(1));
  EXPECT_EQ(pair.left.size(), cv::Size(20, 12));
  EXPECT_EQ(pair.left.type(), CV_8UC1);
  EXPECT_EQ(pair.left.at<std::uint8_t>(3, 4), 'b');
  EXPECT_EQ(pair.right.size(), cv::Size(22, 14));
  EXPECT_EQ(pair.right.at<cv::Vec3b>(3, 4), cv::Vec3b(1, 2, 'b'));
  EXPECT_EQ(pair.truth.kind, TruthKind::kHomography);
  EXPECT_EQ(pair.truth.matrix, cv::Matx33d(1, -0.25, 10.0 * 'b', 0.1215, 1, -7, 1.1e-4, 0, 1));
  EXPECT_FALSE(pair.given.has_value());
}

TEST_F(SymbenchFolder, IsFoundByName) {
  EXPECT_EQ(openDataset("symbench", root_.string())->size(), 3u);
  EXPECT_EQ(openDataset("symbench", root_.string() + "/")->id(1).text(), "symbench/b/1-2");
}

TEST_F(SymbenchFolder, RefusesMissingAndEmptyFolders) {
  const std::string missing = (root_ / "nowhere").string(), empty = (root_ / "empty").string();
  std::string error = errorOf<DatasetError>([&] { openSymbench(missing); });
  EXPECT_TRUE(contains(error, "'" + missing + "' is not a folder; set the path")) << error;
  fs::create_directories(root_ / "empty" / "pair");
  error = errorOf<DatasetError>([&] { openDataset("symbench", empty); });
  EXPECT_TRUE(contains(error, "'" + empty + "' has no complete pair")) << error;
  EXPECT_TRUE(contains(error, "NAME/ with 01.png, 02.png and H1to2")) << error;
}

TEST_F(SymbenchFolder, NamesTheMissingFile) {
  for (const char* name : {"01.png", "02.png", "H1to2"}) {
    const fs::path path = root_ / "b" / name, away = root_ / "b" / "away";
    fs::rename(path, away);
    const std::string error = onlyErrorAtB();
    const fs::path named = path.extension() == ".png" ? fs::path(path).replace_extension() : path;
    EXPECT_TRUE(contains(error, named.string() + ": the ")) << error;
    EXPECT_TRUE(contains(error, " is missing")) << error;
    EXPECT_TRUE(contains(error, "; unpack the pair again")) << error;
    fs::rename(away, path);
  }
}

TEST_F(SymbenchFolder, NamesTheUnreadableImage) {
  fs::resize_file(root_ / "b" / "02.png", 5);
  const std::string error = onlyErrorAtB();
  EXPECT_TRUE(contains(error, (root_ / "b" / "02.png").string() + ": the image cannot be decoded")) << error;
}

TEST_F(SymbenchFolder, RefusesBadHomographies) {
  const struct {
    const char* text;
    const char* expected;
  } cases[] = {
      {"1 0 0\n0 1 0\n0\n", "holds 7 numbers"},
      {"1 0 0 0 one 0 0 0 1", "'one' is not a number"},
      {"1 2 300 2 4 600 0 0 1", "singular"},
  };
  for (const auto& c : cases) {
    write(root_ / "b" / "H1to2", c.text);
    const std::string error = onlyErrorAtB();
    EXPECT_TRUE(contains(error, (root_ / "b" / "H1to2").string())) << error;
    EXPECT_TRUE(contains(error, c.expected)) << error;
  }
}

TEST(Symbench, ReadsTheRealDataset) {
  const std::string folder = sharedData("symbench");
  if (folder.empty()) GTEST_SKIP() << "skipped: the SymBench images are not here";
  const HomographyPairReader reader = openSymbench(folder);
  ASSERT_EQ(reader.size(), 46u);
  std::size_t registered = 0;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    ASSERT_FALSE(pair.left.empty() || pair.right.empty()) << pair.id.text();
    EXPECT_EQ(pair.left.size(), pair.right.size()) << pair.id.text();
    registered += pair.truth.matrix == cv::Matx33d::eye() ? 1 : 0;
  }
  EXPECT_EQ(registered, 31u);
}

/// Matches of the pair that a homography maps to within 10 px.
std::size_t agreeing(const Correspondences& matches, const cv::Matx33d& homography) {
  GroundTruth truth;
  truth.kind = TruthKind::kHomography;
  truth.matrix = homography;
  const std::vector<double> errors = groundTruthErrors(truth, matches);
  return static_cast<std::size_t>(
      std::count_if(errors.begin(), errors.end(), [](double error) { return error <= 10; }));
}

// The photographs of these pairs are alike enough for SIFT to tell left to right from right to left.
TEST(Symbench, HomographiesMapTheFirstImageToTheSecond) {
  const std::string folder = sharedData("symbench");
  if (folder.empty()) GTEST_SKIP() << "skipped: the SymBench images are not here";
  const HomographyPairReader reader = openSymbench(folder);
  const auto extractor = createExtractor("sift+sift");
  std::size_t seen = 0;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const std::string name = reader.id(i).sequence;
    if (name != "cars" && name != "graffiti" && name != "notredame12" && name != "paintedladies12") continue;
    ++seen;
    const ImagePair pair = reader.read(i);
    const Correspondences matches =
        matchFeatures(extractor->extract(pair.left), extractor->extract(pair.right));
    const std::size_t agree = agreeing(matches, pair.truth.matrix);
    EXPECT_GT(agree, 100u) << name;
    EXPECT_GT(agree, 10 * agreeing(matches, pair.truth.matrix.inv())) << name;
    EXPECT_GT(agree, 10 * agreeing(matches, cv::Matx33d::eye())) << name;
  }
  EXPECT_EQ(seen, 4u);
}

}  // namespace
}  // namespace corrsel::core
