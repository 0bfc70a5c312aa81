#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>

#include "base/text.h"
#include "benchmark/saved_matches.h"
#include "corrsel/benchmark/results.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

namespace fs = std::filesystem;

class SavedMatchFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_saved_matches_" + std::to_string(::getpid()));
    fs::remove_all(root_);
    pair_.id = {"set", "scene/1", "a:b"};
    matches_.left_size = {640, 480};
    matches_.add({0.1F, 2}, {3, 4.25F});
    matches_.add({5, 6}, {7, 8});
    matches_.add({1023.7F, 10}, {11, 12});
    selection_.mask = {1, 0, 1};
    selection_.n_selected = 2;
  }
  void TearDown() override { fs::remove_all(root_); }

  std::string text(const std::string& file) const {
    return readTextFile((root_ / "matches" / file).string());
  }

  fs::path root_;
  ImagePair pair_;
  Correspondences matches_;
  Selection selection_;
};

constexpr char kFolder[] = "csv/set/scene%2F1/a%3Ab/sift+sift/nnsr/";

TEST_F(SavedMatchFiles, CoordinatesAlone) {
  SavedMatches saved(root_.string(), pair_, false);
  saved.writePutative({"sift+sift", "nnsr"}, matches_);
  saved.write(matches_, "lpm[lambda=0.5]", 3, selection_);
  EXPECT_EQ(text(std::string(kFolder) + "putative.csv"),
            "x_left,y_left,x_right,y_right\n0.1,2,3,4.25\n5,6,7,8\n1023.7,10,11,12\n");
  EXPECT_EQ(text(std::string(kFolder) + "lpm%5Blambda%3D0.5%5D.csv"),
            "row,x_left,y_left,x_right,y_right\n0,0.1,2,3,4.25\n2,1023.7,10,11,12\n");
  ASSERT_EQ(saved.selections().size(), 1U);
  const SavedSelection& row = saved.selections().front();
  EXPECT_EQ(row.file, std::string(kFolder) + "lpm%5Blambda%3D0.5%5D.csv");
  EXPECT_EQ(row.putative, std::string(kFolder) + "putative.csv");
  EXPECT_EQ(row.id, pair_.id);
  EXPECT_EQ(row.selector, "lpm[lambda=0.5]");
  EXPECT_EQ(row.seed, 3);
  EXPECT_EQ(row.n_putative, 3U);
  EXPECT_EQ(row.n_selected, 2U);
  EXPECT_EQ(row.model_kind, "none");
  EXPECT_EQ(row.model, "");
  EXPECT_EQ(row.left_image, "");
  EXPECT_EQ(row.left_width, 640U);
  EXPECT_EQ(row.right_width, 0U);
}

TEST_F(SavedMatchFiles, EveryColumn) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  matches_.distance = {1, 2, 3};
  matches_.second_distance = {4, 5, nan};
  matches_.probability = {0.25F, 0, 0.75F};
  matches_.left_index = {7, 8, 4000000000U};
  matches_.right_index = {0, 1, 2};
  matches_.left_frame = {{1, 2, 0, 3, 4, 0}, {}, {5, 6, 0, 7, 8, 0}};
  matches_.right_frame = {{}, {}, {-1, 0.5F, 0, 0, 1e-20F, 0}};
  selection_.score = {0.5F, 1, nan};
  selection_.group = {0, -1, 2};
  selection_.probability = {0.875F, 0, 1};
  selection_.model_kind = ModelKind::kHomography;
  selection_.model = cv::Matx33d(1, 0, 0.25, 0, 1, 0, 0, 0, 1);
  pair_.left_name = "db/1.jpg";
  SavedMatches saved(root_.string(), pair_, true);
  saved.writePutative({"sift+sift", "nnsr"}, matches_);
  saved.write(matches_, "usac:h", 12, selection_);
  const std::string columns =
      "x_left,y_left,x_right,y_right,distance,second_distance,match_probability,index_left,"
      "index_right,"
      "a11_left,a12_left,a21_left,a22_left,a11_right,a12_right,a21_right,a22_right";
  EXPECT_EQ(text(std::string(kFolder) + "usac%3Ah@12.csv"),
            "row," + columns +
                ",score,group,probability\n0,0.1,2,3,4.25,1,4,0.25,7,0,1,2,3,4,0,0,0,0,0.5,0,0.875\n" +
                "2,1023.7,10,11,12,3,nan,0.75,4000000000,2,5,6,7,8,-1,0.5,0,1e-20,nan,2,1\n");
  EXPECT_EQ(completeLines(text(std::string(kFolder) + "putative.csv")).front(), columns);
  const SavedSelection& row = saved.selections().front();
  EXPECT_EQ(row.model_kind, "homography");
  EXPECT_EQ(row.model, "1 0 0.25 0 1 0 0 0 1");
  EXPECT_EQ(row.left_image, "db/1.jpg");
}

TEST_F(SavedMatchFiles, EqualImagesHaveEqualNames) {
  const auto namesOf = [this](const cv::Mat& left, const cv::Mat& right) {
    pair_.left = left;
    pair_.right = right;
    SavedMatches saved(root_.string(), pair_, false);
    saved.writePutative({"orb+orb", "none"}, matches_);
    saved.write(matches_, "gms", 0, selection_);
    return std::pair(saved.selections().front().left_image, saved.selections().front().right_image);
  };
  cv::Mat image(20, 30, CV_8U, cv::Scalar(9)), other = image.clone();
  other.at<std::uint8_t>(3, 4) = 10;
  const auto [left, right] = namesOf(image, other);
  EXPECT_EQ(left.size(), 17U);
  EXPECT_EQ(left.front(), '#');
  EXPECT_NE(left, right);
  EXPECT_EQ(namesOf(image.clone(), image), std::pair(left, left));
  EXPECT_NE(namesOf(image.reshape(1, 30), image).first, left);
}

TEST_F(SavedMatchFiles, EmptyPairsHaveTheirColumns) {
  SavedMatches saved(root_.string(), pair_, false);
  saved.writePutative({"sift+sift", "nnsr"}, Correspondences());
  saved.write(Correspondences(), "gms", 0, Selection());
  EXPECT_EQ(text(std::string(kFolder) + "putative.csv"), "x_left,y_left,x_right,y_right\n");
  EXPECT_EQ(text(std::string(kFolder) + "gms.csv"), "row,x_left,y_left,x_right,y_right\n");
}

TEST_F(SavedMatchFiles, CopiedWithTheirPutativeMatches) {
  SavedMatches saved((root_ / "from").string(), pair_, false);
  saved.writePutative({"sift+sift", "nnsr"}, matches_);
  saved.write(matches_, "gms", 0, selection_);
  copySavedMatches((root_ / "from").string(), (root_ / "to").string(), saved.selections());
  for (const char* file : {"putative.csv", "gms.csv"}) {
    const fs::path name = fs::path("matches") / kFolder / file;
    const std::string copied = readTextFile((root_ / "to" / name).string());
    EXPECT_FALSE(copied.empty()) << file;
    EXPECT_EQ(copied, readTextFile((root_ / "from" / name).string()));
  }
  fs::remove_all(root_ / "from");
  const std::string error = errorOf(
      [&] { copySavedMatches((root_ / "from").string(), (root_ / "to").string(), saved.selections()); });
  EXPECT_TRUE(contains(error, "cannot copy") && contains(error, "putative.csv")) << error;
}

TEST_F(SavedMatchFiles, FolderThatCannotBeMade) {
  fs::create_directories(root_);
  std::ofstream(root_ / "matches") << "a file is in the way";
  SavedMatches saved(root_.string(), pair_, false);
  const std::string error = errorOf([&] { saved.writePutative({"sift+sift", "nnsr"}, matches_); });
  EXPECT_TRUE(contains(error, "cannot create the folder")) << error;
}

}  // namespace
}  // namespace corrsel::core
