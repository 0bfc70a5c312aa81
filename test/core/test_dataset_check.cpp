#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "benchmark/dataset_check.h"
#include "corrsel/random.h"
#include "dataset_folder.h"
#include "datasets/dataset_report.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

std::string text(const cv::Matx33d& matrix) {
  std::ostringstream out;
  for (const double value : matrix.val) out << value << " ";
  return out.str();
}

/// Looks at all pairs that can be read.
PairInspector inspected(const DatasetReader& reader) {
  PairInspector inspector(2);
  describe(reader, evenlySpaced(reader.size(), reader.size()),
           {[&inspector](const ImagePair& pair) { inspector.add(pair); }});
  return inspector;
}

/// A pair of blank images.
ImagePair blankPair(const std::string& name, const cv::Size& left, const cv::Size& right) {
  ImagePair pair;
  pair.id = {"mine", "s", name};
  pair.left = cv::Mat(left, CV_8U, cv::Scalar(0));
  pair.right = cv::Mat(right, CV_8U, cv::Scalar(0));
  return pair;
}

std::vector<std::string> oddSizes(const std::vector<ImagePair>& pairs) {
  PairInspector inspector(1);
  for (const ImagePair& pair : pairs) inspector.add(pair);
  return inspector.oddSizes();
}

class DatasetCheck : public DatasetFolder {
 protected:
  /// A pair in the layout `pairs`: a picture of random discs, and the same picture moved by a homography.
  void writePair(const std::string& name, const cv::Matx33d& homography, const cv::Matx33d& given) const {
    Random random(1);
    cv::Mat left(480, 640, CV_8U, cv::Scalar(40)), right;
    for (int k = 0; k < 400; ++k) {
      const int x = static_cast<int>(random.index(640)), y = static_cast<int>(random.index(480));
      const int radius = 2 + static_cast<int>(random.index(12));
      cv::circle(left, {x, y}, radius, cv::Scalar(random.uniform(60, 255)), -1);
    }
    cv::warpPerspective(left, right, homography, left.size());
    write(fs::path(name) / "H.txt", text(given));
    ASSERT_TRUE(cv::imwrite(path(fs::path(name) / "left.png"), left));
    ASSERT_TRUE(cv::imwrite(path(fs::path(name) / "right.png"), right));
  }
};

TEST_F(DatasetCheck, SequencesInTheWrongDirectionAreNamed) {
  const cv::Matx33d moved(0.9, 0.08, 20, -0.08, 0.9, 60, 0, 0, 1);
  writePair("desk", moved, moved);
  writePair("table", moved, moved.inv());
  writePair("wall", cv::Matx33d::eye(), cv::Matx33d::eye());
  write("broken/H.txt", "1 0 0 0 1 0 0 0 1");
  const PairInspector inspector = inspected(*openDataset("pairs", path()));
  EXPECT_TRUE(inspector.oddSizes().empty());
  const std::vector<TruthWarning> warnings = inspector.doubtfulTruths();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].id, (PairId{"pairs", "table", ""}));
  EXPECT_EQ(warnings[0].counts.reading, "inverse");
  EXPECT_GT(warnings[0].counts.n_reading, 10 * warnings[0].counts.n_truth);
}

TEST(OddSizes, HomographyThatLeadsOutOfTheImage) {
  ImagePair pair = blankPair("1-2", {640, 480}, {320, 240});
  pair.truth.kind = TruthKind::kHomography;
  EXPECT_TRUE(oddSizes({pair}).empty());
  // A file may state -H.
  pair.truth.matrix = cv::Matx33d::eye() * -1.0;
  EXPECT_TRUE(oddSizes({pair}).empty());
  pair.truth.matrix = cv::Matx33d(1, 0, 320, 0, 1, 0, 0, 0, 1);
  EXPECT_EQ(oddSizes({pair}), std::vector<std::string>{
                                  "mine/s/1-2: the homography maps 0 % of the left image into the right one "
                                  "(the images have 640x480 and 320x240 px); the images or the homography "
                                  "are of another pair, or the images have been scaled"});
}

TEST(OddSizes, EpipolarLinesThatMissTheImage) {
  ImagePair pair = blankPair("1-2", {640, 480}, {640, 480});
  pair.truth.kind = TruthKind::kFundamental;
  pair.truth.matrix = cv::Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 0);  // y' = y
  EXPECT_TRUE(oddSizes({pair}).empty());
  pair.truth.matrix = cv::Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 480);  // y' = y + 480
  const std::vector<std::string> odd = oddSizes({pair});
  ASSERT_EQ(odd.size(), 1U);
  EXPECT_TRUE(contains(odd[0], "the epipolar lines of 0 % of the left image cross the right one")) << odd[0];
}

TEST(OddSizes, DisparitiesAndCameras) {
  ImagePair pair = blankPair("1-2", {640, 480}, {640, 480});
  pair.truth.kind = TruthKind::kDisparity;
  pair.truth.disparity = cv::Mat(480, 640, CV_32F, cv::Scalar(3));
  pair.truth.pose.emplace();
  pair.truth.pose->left_camera = pair.truth.pose->right_camera =
      cv::Matx33d(500, 0, 320, 0, 500, 240, 0, 0, 1);
  EXPECT_TRUE(oddSizes({pair}).empty());
  pair.truth.pose->right_camera(0, 2) = 700;
  std::vector<std::string> odd = oddSizes({pair});
  ASSERT_EQ(odd.size(), 1U);
  EXPECT_TRUE(
      contains(odd[0], "mine/s/1-2: the principal point of the right camera, (700, 240), lies outside"))
      << odd[0];
}

TEST(OddSizes, OneImageOfASequence) {
  std::vector<ImagePair> pairs;
  for (const char* name : {"1-2", "1-3", "1-4", "1-5"}) pairs.push_back(blankPair(name, {64, 48}, {80, 60}));
  EXPECT_TRUE(oddSizes(pairs).empty());
  pairs.push_back(blankPair("1-6", {64, 48}, {60, 80}));
  EXPECT_EQ(oddSizes(pairs),
            std::vector<std::string>{
                "mine/s/1-6: the right image has 60x80 px, and the right images of the other pairs of the "
                "sequence have 80x60 px; it is probably scaled or of another sequence"});
  // Two other images are too few to tell, and a size that occurs twice is no mistake.
  EXPECT_EQ(oddSizes({pairs[0], pairs[1], pairs[2], pairs[4]}).size(), 1U);
  EXPECT_TRUE(oddSizes({pairs[0], pairs[1], pairs[4]}).empty());
  pairs.push_back(blankPair("1-7", {64, 48}, {60, 80}));
  EXPECT_TRUE(oddSizes(pairs).empty());
}

TEST_F(DatasetCheck, PublishedDatasetsAreInOrder) {
  for (const char* name : {"vgg", "symbench", "adelaidermf"}) {
    const std::string folder = sharedData(name);
    if (folder.empty()) GTEST_SKIP() << "no real data";
    const PairInspector inspector = inspected(*openDataset(name, folder));
    for (const std::string& odd : inspector.oddSizes()) ADD_FAILURE() << odd;
    for (const TruthWarning& warning : inspector.doubtfulTruths()) ADD_FAILURE() << warning.text();
  }
}

}  // namespace
}  // namespace corrsel::core
