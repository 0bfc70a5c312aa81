#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "dataset_folder.h"
#include "datasets/heinly_generated.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

class HeinlyGenerated : public DatasetFolder {
 protected:
  void SetUp() override {
    DatasetFolder::SetUp();
    if (!fs::is_regular_file(fs::path(samplePhotographs()) / "scenetext03.jpg")) {
      GTEST_SKIP() << "skipped: the sample images are not here; run: rosrun corrsel fetch_samples.sh";
    }
  }
};

TEST_F(HeinlyGenerated, HasFourScenesAnd29Pairs) {
  const auto reader = openDataset("heinly_generated", samplePhotographs());
  ASSERT_EQ(reader->size(), 29u);
  std::map<std::string, int> pairs;
  for (std::size_t i = 0; i < reader->size(); ++i) {
    const PairId id = reader->id(i);
    EXPECT_EQ(id.dataset, "heinly_generated");
    EXPECT_EQ(id.pair, "0-" + std::to_string(++pairs[id.sequence]));
    EXPECT_NO_THROW(reader->check(i));
  }
  EXPECT_EQ(pairs,
            (std::map<std::string, int>{{"rotation_1", 7}, {"rotation_2", 8}, {"zoom_1", 7}, {"zoom_2", 7}}));
  EXPECT_EQ(reader->files().size(), 4u);
  EXPECT_THROW(reader->id(29), std::out_of_range);
}

TEST_F(HeinlyGenerated, ZoomsAndRotatesAndNothingElse) {
  const HeinlyGeneratedReader reader(samplePhotographs(), 3);
  std::string sequence;
  double last = 0.0;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    SCOPED_TRACE(pair.id.text());
    ASSERT_EQ(pair.truth.kind, TruthKind::kHomography);
    ASSERT_EQ(pair.left.size(), pair.right.size());
    const cv::Matx33d& h = pair.truth.matrix;
    const cv::Point2d centre(0.5 * (pair.left.cols - 1), 0.5 * (pair.left.rows - 1));
    EXPECT_LT(cv::norm(projected(h, centre.x, centre.y) - centre), 1e-9);
    EXPECT_NEAR(h(0, 0), h(1, 1), 1e-12);
    EXPECT_NEAR(h(0, 1), -h(1, 0), 1e-12);
    EXPECT_EQ(h(2, 0), 0.0);
    const double zoom = 1 / std::hypot(h(0, 0), h(1, 0));
    const double turn = std::fmod(std::atan2(h(1, 0), h(0, 0)) * 180 / CV_PI + 360.0, 360.0);
    const bool zooms = pair.id.sequence.rfind("zoom", 0) == 0;
    EXPECT_NEAR(zooms ? turn : zoom - 1.0, 0.0, 1e-9);
    if (pair.id.sequence != sequence) last = zooms ? 1.0 : 0.0;
    EXPECT_GT(zooms ? zoom : turn, last + 0.1);
    sequence = pair.id.sequence;
    last = zooms ? zoom : turn;
    if (pair.id.text() == "heinly_generated/zoom_1/0-7") {
      EXPECT_NEAR(zoom, 4.0, 1e-9);
    }
    if (pair.id.text() == "heinly_generated/rotation_2/0-8") {
      EXPECT_NEAR(turn, 320.0, 1e-9);
    }
  }
}

TEST_F(HeinlyGenerated, ImagesFollowTheHomography) {
  const HeinlyGeneratedReader reader(samplePhotographs());
  for (const std::size_t i : {0u, 13u, 14u, 17u, 28u}) {
    const ImagePair pair = reader.read(i);
    SCOPED_TRACE(pair.id.text());
    cv::Mat inside(pair.left.size(), CV_8U, cv::Scalar(255)), warped, right, difference;
    cv::warpPerspective(inside, inside, pair.truth.matrix, inside.size());
    cv::erode(inside, inside, cv::Mat(), cv::Point(-1, -1), 8);
    cv::warpPerspective(pair.left, warped, pair.truth.matrix, pair.left.size());
    cv::GaussianBlur(warped, warped, cv::Size(), 3.0);
    cv::GaussianBlur(pair.right, right, cv::Size(), 3.0);
    cv::absdiff(warped, right, difference);
    const cv::Scalar mean = cv::mean(difference, inside);
    for (int c = 0; c < difference.channels(); ++c) EXPECT_LT(mean[c], 5.0) << "channel " << c;
    EXPECT_GT(cv::countNonZero(inside), 0.04 * double(inside.total()));
  }
}

TEST_F(HeinlyGenerated, DependsOnSeedAndPairAlone) {
  const HeinlyGeneratedReader a(samplePhotographs(), 7), b(samplePhotographs(), 7),
      other(samplePhotographs(), 8);
  b.read(20);
  const cv::Mat first = a.read(3).right;
  EXPECT_EQ(cv::norm(first, b.read(3).right, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(first, other.read(3).right, cv::NORM_INF), 0.0);
}

TEST_F(HeinlyGenerated, NamesTheMissingPhotograph) {
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { HeinlyGeneratedReader reader(path()); }), "fetch_samples.sh"));
  fs::copy(fs::path(samplePhotographs()) / "aero1.jpg", root_ / "aero1.jpg");
  const HeinlyGeneratedReader reader(path());
  for (const std::size_t i : {0u, 28u}) {
    const std::string error = errorOf<DatasetError>([&] { reader.read(i); });
    EXPECT_TRUE(contains(error, path(i == 0 ? "scenetext03.jpg" : "building.jpg"))) << error;
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(i); }), error);
  }
  EXPECT_NO_THROW(reader.read(14));
}

}  // namespace
}  // namespace corrsel::core
