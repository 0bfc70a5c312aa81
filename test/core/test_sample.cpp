#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

#include "base/checksum.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "dataset_folder.h"
#include "datasets/sample.h"
#include "geometry/fundamental.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

struct Match {
  cv::Point2f left, right;
};

/// SIFT matches that pass the ratio test at 0.7.
std::vector<Match> siftMatches(const ImagePair& pair) {
  const auto sift = createExtractor("sift+sift", {{"sift", {{"max_features", "2000"}}}});
  const Correspondences all = matchFeatures(sift->extract(pair.left), sift->extract(pair.right));
  std::vector<Match> matches;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all.distance[i] < 0.7F * all.second_distance[i]) {
      matches.push_back({{all.left_x[i], all.left_y[i]}, {all.right_x[i], all.right_y[i]}});
    }
  }
  return matches;
}

/// Part of the matches that lie within `tolerance` px of the homography.
double agreement(const ImagePair& pair, const std::vector<Match>& matches, double tolerance) {
  const auto agrees = [&](const Match& m) {
    return cv::norm(projected(pair.truth.matrix, m.left.x, m.left.y) - cv::Point2d(m.right)) <= tolerance;
  };
  return double(std::count_if(matches.begin(), matches.end(), agrees)) / double(matches.size());
}

/// Checksum over the pairs from `begin` to before `end`: matrix or disparity, left image, right image.
std::uint64_t fingerprint(const DatasetReader& reader, std::size_t begin, std::size_t end) {
  Checksum checksum;
  for (std::size_t i = begin; i < end; ++i) {
    const ImagePair pair = reader.read(i);
    checksum.add(pair.truth.matrix.val, sizeof(pair.truth.matrix.val));
    for (const cv::Mat& image : {pair.truth.disparity, pair.left, pair.right}) {
      for (int y = 0; y < image.rows; ++y) {
        checksum.add(image.ptr(y), image.elemSize() * std::size_t(image.cols));
      }
    }
  }
  return checksum.value();
}

class SampleImages : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const std::string& name : SampleReader::imageNames()) {
      if (!fs::is_regular_file(fs::path(samplePhotographs()) / name)) {
        GTEST_SKIP() << "skipped: the sample images are not here; run: rosrun corrsel fetch_samples.sh";
      }
    }
  }
};

TEST_F(SampleImages, HasSixteenRealAndFiftyGeneratedPairs) {
  const SampleReader reader(samplePhotographs());
  ASSERT_EQ(reader.size(), 66u);
  EXPECT_EQ(reader.id(0).text(), "sample/graf/1-3");
  EXPECT_EQ(reader.id(1).text(), "sample/aloe/L-R");
  EXPECT_EQ(reader.id(2).text(), "sample/zoom_rotation_1/0-1");
  EXPECT_EQ(reader.id(51).text(), "sample/rotation/0-5");
  EXPECT_EQ(reader.id(52).text(), "sample/rig/01");
  EXPECT_EQ(reader.id(56).text(), "sample/rig/06");
  EXPECT_EQ(reader.id(63).text(), "sample/rig/14");
  EXPECT_EQ(reader.id(64).text(), "sample/box/1-2");
  EXPECT_EQ(reader.id(65).text(), "sample/page/5-6");
  EXPECT_THROW(reader.id(66), std::out_of_range);
  EXPECT_EQ(reader.files().size(), SampleReader::imageNames().size());
  std::set<std::string> sequences;
  for (std::size_t i = 2; i < SampleReader::kFirstReal; ++i) sequences.insert(reader.id(i).sequence);
  EXPECT_EQ(sequences, (std::set<std::string>{"blur_1", "blur_2", "jpeg", "light", "rotation", "viewpoint_1",
                                              "viewpoint_2", "zoom", "zoom_rotation_1", "zoom_rotation_2"}));
}

TEST_F(SampleImages, DependsOnSeedAndPairAlone) {
  const SampleReader forwards(samplePhotographs(), 7), backwards(samplePhotographs(), 7),
      other(samplePhotographs(), 8);
  const std::vector<std::size_t> pairs = {2, 6, 12, 22, 35, 41, 50};
  std::vector<ImagePair> first;
  for (const std::size_t i : pairs) first.push_back(forwards.read(i));
  for (std::size_t k = pairs.size(); k-- > 0;) {
    const ImagePair again = backwards.read(pairs[k]);
    EXPECT_TRUE(same(again.left, first[k].left)) << again.id.text();
    EXPECT_TRUE(same(again.right, first[k].right)) << again.id.text();
    EXPECT_EQ(again.truth.matrix, first[k].truth.matrix) << again.id.text();
    EXPECT_FALSE(same(other.read(pairs[k]).right, first[k].right)) << again.id.text();
  }
}

// Results that were published for the sample set hold only as long as its pairs stay the same bit by bit,
// on every machine.
TEST_F(SampleImages, PairsStayTheSame) {
  const SampleReader reader(samplePhotographs());
  EXPECT_EQ(fingerprint(reader, 0, SampleReader::kFirstReal), 16603200520215728185u);
  EXPECT_EQ(fingerprint(reader, SampleReader::kFirstReal, reader.size()), 6413103595355498787u);
}

TEST_F(SampleImages, GeneratedPairsFollowTheirHomographies) {
  const SampleReader reader(samplePhotographs());
  for (std::size_t i = 2; i < SampleReader::kFirstReal; ++i) {
    const ImagePair pair = reader.read(i);
    SCOPED_TRACE(pair.id.text());
    ASSERT_EQ(pair.left.size(), pair.right.size());
    ASSERT_EQ(pair.left.type(), pair.right.type());
    ASSERT_EQ(pair.truth.kind, TruthKind::kHomography);
    // Every left pixel is in front of the camera.
    for (const double x : {0.0, pair.left.cols - 1.0}) {
      for (const double y : {0.0, pair.left.rows - 1.0}) {
        EXPECT_GT((pair.truth.matrix * cv::Vec3d(x, y, 1.0))[2], 0.0);
      }
    }
    const cv::Point2d centre(0.5 * (pair.left.cols - 1), 0.5 * (pair.left.rows - 1));
    EXPECT_LT(cv::norm(projected(pair.truth.matrix, centre.x, centre.y) - centre), 0.05 * pair.left.cols);

    // At the weakest strength most distinctive features must be where the homography puts them.
    if (pair.id.pair != "0-1") continue;
    const std::vector<Match> matches = siftMatches(pair);
    EXPECT_GT(matches.size(), 100u);
    EXPECT_GT(agreement(pair, matches, 3.0), 0.9);
  }
}

TEST_F(SampleImages, GeneratedPairsLookLikeTheWarpedPhotograph) {
  const SampleReader reader(samplePhotographs());
  for (std::size_t i = 2; i < SampleReader::kFirstReal; i += 5) {
    const ImagePair pair = reader.read(i);
    SCOPED_TRACE(pair.id.text());
    cv::Mat inside(pair.left.size(), CV_8U, cv::Scalar(255)), warped, right;
    cv::warpPerspective(inside, inside, pair.truth.matrix, inside.size());
    cv::erode(inside, inside, cv::Mat(), cv::Point(-1, -1), 8);
    cv::warpPerspective(pair.left, warped, pair.truth.matrix, pair.left.size());
    // Equal smoothing leaves little of the nuisances but the light, a gain at this strength.
    cv::GaussianBlur(warped, warped, cv::Size(), 3.0);
    cv::GaussianBlur(pair.right, right, cv::Size(), 3.0);
    if (pair.id.sequence == "light") right /= 0.8;
    cv::Mat difference;
    cv::absdiff(warped, right, difference);
    const cv::Scalar mean = cv::mean(difference, inside);
    for (int c = 0; c < difference.channels(); ++c) EXPECT_LT(mean[c], 5.0) << "channel " << c;
    EXPECT_GT(cv::countNonZero(inside), 0.2 * double(inside.total()));
  }
}

TEST_F(SampleImages, GrafFollowsItsHomography) {
  const ImagePair pair = SampleReader(samplePhotographs()).read(0);
  ASSERT_EQ(pair.truth.kind, TruthKind::kHomography);
  EXPECT_EQ(pair.left_name, "graf1.png");
  EXPECT_EQ(pair.right_name, "graf3.png");
  const std::vector<Match> matches = siftMatches(pair);
  EXPECT_GT(matches.size(), 100u);
  EXPECT_GT(agreement(pair, matches, 5.0), 0.7);
}

TEST_F(SampleImages, AloeFollowsItsDisparity) {
  const ImagePair pair = SampleReader(samplePhotographs()).read(1);
  ASSERT_EQ(pair.truth.kind, TruthKind::kDisparity);
  EXPECT_EQ(pair.left_name, "aloeL.jpg");
  EXPECT_EQ(pair.right_name, "aloeR.jpg");
  ASSERT_EQ(pair.truth.disparity.type(), CV_32F);
  ASSERT_EQ(pair.truth.disparity.size(), pair.left.size());
  int known = 0, right = 0;
  for (const Match& m : siftMatches(pair)) {
    const float disparity = pair.truth.disparity.at<float>(cvRound(m.left.y), cvRound(m.left.x));
    // The wallpaper repeats itself, but seldom in the same row.
    if (std::isnan(disparity) || std::abs(m.left.y - m.right.y) > 1.0f) continue;
    ++known;
    right += std::abs(m.left.x - disparity - m.right.x) <= 5.0f;
  }
  EXPECT_GT(known, 100);
  EXPECT_GT(right, 0.9 * known);
  const double unknown = std::count_if(pair.truth.disparity.begin<float>(), pair.truth.disparity.end<float>(),
                                       [](float d) { return std::isnan(d); });
  EXPECT_NEAR(unknown / double(pair.truth.disparity.total()), 0.0345, 0.0001);
}

TEST_F(SampleImages, PoseOfAloeAgreesWithItsDisparity) {
  const GroundTruth truth = SampleReader(samplePhotographs()).read(1).truth;
  ASSERT_TRUE(truth.pose);
  ASSERT_NO_THROW(truth.pose->check());
  const cv::Matx33d f = truth.pose->fundamental();
  const cv::Matx33d &left = truth.pose->left_camera, &right = truth.pose->right_camera;
  for (int y = 0; y < truth.disparity.rows; y += 10) {
    for (int x = 0; x < truth.disparity.cols; x += 10) {
      const float disparity = truth.disparity.at<float>(y, x);
      if (std::isnan(disparity)) continue;
      const double right_x = x - double(disparity);
      ASSERT_LT(epipolarLineDistance(f, x, y, right_x, y), 1e-9);
      ASSERT_GT(epipolarLineDistance(f, x, y, right_x, y + 2), 1.9);
      // The point lies where depth = focal length * baseline / disparity puts it; 270 px were subtracted.
      const double depth = left(0, 0) * 0.16 / (disparity + 270.0);
      const cv::Vec3d point = left.inv() * cv::Vec3d(x, y, 1) * depth;
      const cv::Vec3d seen = right * (truth.pose->rotation * point + truth.pose->translation);
      ASSERT_NEAR(seen[0] / seen[2], right_x, 1e-6);
    }
  }
}

/// The share of the distinctive matches that lie within 1 px of the truth. `other` exchanges each right point
/// for that of another match.
double shareWithin(const ImagePair& pair, bool other) {
  const std::vector<Match> found = siftMatches(pair);
  Correspondences matches;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Match& right = found[other ? (i + found.size() / 2) % found.size() : i];
    matches.add(found[i].left, right.right);
  }
  pair.addCamerasTo(matches);
  const std::vector<double> errors = groundTruthErrors(pair.truth, matches);
  const auto near = std::count_if(errors.begin(), errors.end(), [](double e) { return e <= 1; });
  return double(near) / double(errors.size());
}

// The board repeats itself, so that many matches on it are wrong. Beside it, the calibration was not fitted.
TEST_F(SampleImages, RealPairsFollowTheirTruth) {
  const SampleReader reader(samplePhotographs());
  for (std::size_t i = SampleReader::kFirstReal; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    SCOPED_TRACE(pair.id.text());
    const bool rig = pair.id.sequence == "rig";
    EXPECT_EQ(pair.truth.kind, rig ? TruthKind::kEssential : TruthKind::kHomography);
    EXPECT_FALSE(pair.truth.pose.has_value());
    EXPECT_EQ(pair.left_camera.has_value() && pair.right_camera.has_value(), rig);
    EXPECT_FALSE(pair.left_name.empty() || pair.right_name.empty());
    EXPECT_GT(shareWithin(pair, false), 0.3);
    EXPECT_LT(shareWithin(pair, true), 0.1);
  }
}

TEST_F(SampleImages, TrainingImagesAreThoseOfTheFirstPairs) {
  const std::vector<std::string> all = SampleReader::imageNames(), training = SampleReader::trainingImages();
  EXPECT_EQ(training.size(), 14u);
  EXPECT_EQ(training.front(), "graf1.png");
  EXPECT_EQ(training.back(), "aero1.jpg");
  for (const std::string& name : training) EXPECT_EQ(std::count(all.begin(), all.end(), name), 1) << name;
}

TEST_F(SampleImages, NamesTheMissingOrBrokenFile) {
  const fs::path copy = fs::temp_directory_path() / ("corrsel_sample_" + std::to_string(::getpid()));
  fs::remove_all(copy);
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { SampleReader reader(copy.string()); }), "fetch_samples.sh"));
  fs::create_directories(copy);
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { SampleReader reader(copy.string()); }), "fetch_samples.sh"));

  for (const std::string& name : SampleReader::imageNames())
    fs::copy(fs::path(samplePhotographs()) / name, copy / name);
  fs::remove(copy / "baboon.jpg");
  fs::remove(copy / "right03.jpg");
  fs::copy_file(copy / "box_in_scene.png", copy / "box.png", fs::copy_options::overwrite_existing);
  fs::resize_file(copy / "graf3.png", 1000);
  std::ofstream(copy / "aloeGT.png") << "no image";
  const SampleReader reader(copy.string());
  const struct {
    std::size_t pair;
    const char* file;
  } cases[] = {{0, "graf3.png"},   {1, "aloeGT.png"},   {12, "baboon.jpg"},
               {16, "baboon.jpg"}, {54, "right03.jpg"}, {64, "box.png"}};
  for (const auto& c : cases) {
    const std::string error = errorOf<DatasetError>([&] { reader.read(c.pair); });
    EXPECT_TRUE(contains(error, (copy / c.file).string())) << error;
    EXPECT_TRUE(contains(error, "fetch_samples.sh")) << error;
  }
  EXPECT_NO_THROW(reader.read(2));
  EXPECT_NO_THROW(reader.read(17));
  EXPECT_NO_THROW(reader.read(53));
  EXPECT_THROW(reader.check(54), DatasetError);
  EXPECT_NO_THROW(reader.check(53));

  fs::copy_file(fs::path(samplePhotographs()) / "graf3.png", copy / "graf3.png",
                fs::copy_options::overwrite_existing);
  for (const char* text : {"<?xml", "<?xml version=\"1.0\"?><opencv_storage><H>1</H></opencv_storage>"}) {
    std::ofstream(copy / "H1to3p.xml") << text;
    const std::string error = errorOf<DatasetError>([&] { reader.read(0); });
    EXPECT_TRUE(contains(error, (copy / "H1to3p.xml").string())) << error;
  }
  fs::remove_all(copy);
}

TEST(Sample, FetchScriptKnowsTheSameFiles) {
  const fs::path script = fs::path(corrsel::testing::sourceDir()) / "scripts" / "fetch_samples.sh";
  std::ifstream stream(script);
  ASSERT_TRUE(stream) << script;
  std::stringstream content;
  content << stream.rdbuf();
  const std::string text = content.str();
  const std::size_t begin = text.find("files=(");
  ASSERT_NE(begin, std::string::npos);
  std::istringstream list(text.substr(begin + 7, text.find(')', begin) - begin - 7));
  std::set<std::string> fetched;
  for (std::string path; list >> path;) fetched.insert(fs::path(path).filename().string());
  const std::vector<std::string> names = SampleReader::imageNames();
  EXPECT_EQ(fetched, std::set<std::string>(names.begin(), names.end()));
}

}  // namespace
}  // namespace corrsel::core
