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
  const std::vector<TruthWarning> warnings = doubtfulTruths(*openDataset("pairs", path()), 2);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].id, (PairId{"pairs", "table", ""}));
  EXPECT_EQ(warnings[0].counts.reading, "inverse");
  EXPECT_GT(warnings[0].counts.n_reading, 10 * warnings[0].counts.n_truth);
}

TEST_F(DatasetCheck, PublishedDatasetsAreInOrder) {
  for (const char* name : {"vgg", "symbench"}) {
    const std::string folder = sharedData(name);
    if (folder.empty()) GTEST_SKIP() << "no real data";
    for (const TruthWarning& warning : doubtfulTruths(*openDataset(name, folder), 2)) {
      ADD_FAILURE() << warning.text();
    }
  }
}

}  // namespace
}  // namespace corrsel::core
