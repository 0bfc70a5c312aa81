#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/truth_check.h"
#include "corrsel/random.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/dataset_bag_writer.h"
#include "ros/bags/open_bag.h"
#include "ros/bags/stereo_rig.h"

namespace corrsel {

/// corrsel/Correspondences as another version of the package defines it.
struct OtherVersion {
  std_msgs::Header header;
};

}  // namespace corrsel

namespace ros::message_traits {
template <>
struct MD5Sum<corrsel::OtherVersion> {
  static const char* value() { return "0123456789abcdef0123456789abcdef"; }
  static const char* value(const corrsel::OtherVersion&) { return value(); }
};
template <>
struct DataType<corrsel::OtherVersion> {
  static const char* value() { return "corrsel/Correspondences"; }
  static const char* value(const corrsel::OtherVersion&) { return value(); }
};
template <>
struct Definition<corrsel::OtherVersion> {
  static const char* value() { return "Header header\n"; }
  static const char* value(const corrsel::OtherVersion&) { return value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<corrsel::OtherVersion> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message message) {
    stream.next(message.header);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};
}  // namespace ros::serialization

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr char kMatches[] = "/correspondences", kSelected[] = "/matches",
               kLeftInfo[] = "/stereo/left/camera_info", kRightInfo[] = "/stereo/right/camera_info";
constexpr int kWidth = 640, kHeight = 480;

/// Half of a rig with a baseline of 0.1 m and a lens that moves the corners by some 40 px.
sensor_msgs::CameraInfo cameraInfo(bool right) {
  sensor_msgs::CameraInfo info;
  info.header.frame_id = right ? "right_optical" : "left_optical";
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = "plumb_bob";
  info.D = {-0.3, 0.1, 0.001, right ? 0.002 : -0.001, 0};
  info.K = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  const double turn = right ? 0.02 : -0.01;
  info.R = {1, 0, 0, 0, std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn)};
  info.P = {480, 0, 320, right ? -48.0 : 0.0, 0, 480, 240, 0, 0, 0, 1, 0};
  return info;
}

StereoRig rig(bool is_rectified) {
  return {RigCamera{cameraInfo(false), is_rectified, kLeftInfo},
          RigCamera{cameraInfo(true), is_rectified, kRightInfo}};
}

/// Where a camera without rectification sees a point of the left rectified frame, px.
cv::Point2f seenBy(const sensor_msgs::CameraInfo& info, const cv::Vec3d& point) {
  const cv::Matx33d r(info.R.data());
  const cv::Vec3d turned = r.t() * (point + cv::Vec3d(info.P[3] / info.P[0], 0, 0));
  std::vector<cv::Point2d> seen;
  cv::projectPoints(std::vector<cv::Point3d>{{turned[0], turned[1], turned[2]}}, cv::Vec3d(), cv::Vec3d(),
                    cv::Matx33d(info.K.data()), info.D, seen);
  return seen.front();
}

/// Where a rectified camera sees it, px.
cv::Point2f rectifiedBy(const sensor_msgs::CameraInfo& info, const cv::Vec3d& point) {
  const double x = info.P[0] * point[0] + info.P[2] * point[2] + info.P[3];
  const double y = info.P[5] * point[1] + info.P[6] * point[2];
  return {static_cast<float>(x / point[2]), static_cast<float>(y / point[2])};
}

/// Inliers of points 2 to 6 m away, in the middle of the images, so that none is beyond the area kept.
core::Correspondences sceneMatches(bool is_rectified, std::size_t n = 60) {
  core::Random random(3);
  core::Correspondences matches;
  matches.left_size = matches.right_size = {kWidth, kHeight};
  const auto project = is_rectified ? rectifiedBy : seenBy;
  for (std::size_t i = 0; i < n; ++i) {
    const double depth = random.uniform(2, 6);
    const double y = random.uniform(-0.35, 0.35) * depth;
    const double x = random.uniform(-0.45, 0.45) * depth;
    const cv::Vec3d point(x, y, depth);
    matches.add(project(cameraInfo(false), point), project(cameraInfo(true), point));
  }
  return matches;
}

/// Matches as FeatureMatcher sends them.
Correspondences recorded(double stamp, const core::Correspondences& matches, double right_stamp = 0) {
  PairInfo info;
  info.header.stamp = ros::Time(stamp);
  info.header.frame_id = "left_optical";
  info.right_stamp = ros::Time(right_stamp > 0 ? right_stamp : stamp);
  info.right_frame_id = "right_optical";
  info.features = "orb+orb";
  return toMsg(matches, info);
}

void writeMatches(rosbag::Bag& bag, const std::string& topic, double stamp,
                  const core::Correspondences& matches, double right_stamp = 0) {
  bag.write(topic, ros::Time(stamp), recorded(stamp, matches, right_stamp));
}

void writeInfos(rosbag::Bag& bag, const std::string& left = kLeftInfo,
                const std::string& right = kRightInfo) {
  bag.write(left, ros::Time(1), cameraInfo(false));
  bag.write(right, ros::Time(1), cameraInfo(true));
}

bool hasNote(const BagSource& source, const std::string& part) {
  for (const std::string& note : source.notes()) {
    if (note.find(part) != std::string::npos) return true;
  }
  return false;
}

class RecordedBag : public ::testing::Test {
 protected:
  RecordedBag() : folder_(fs::temp_directory_path() / ("corrsel_recorded_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    bag_.open(path(), rosbag::bagmode::Write);
  }
  ~RecordedBag() override { fs::remove_all(folder_); }

  std::string path() const { return (folder_ / "drive.bag").string(); }

  std::unique_ptr<BagSource> open(const BagTopics& topics = {}) {
    bag_.close();
    return openBag(path(), topics);
  }

  /// What opening the bag is refused with.
  std::string refusal(const BagTopics& topics = {}) {
    bag_.close();
    try {
      openBag(path(), topics);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
  rosbag::Bag bag_;
};

TEST_F(RecordedBag, PutativeMatchesAreTakenNotTheSelectedOnes) {
  const core::Correspondences all = sceneMatches(true);
  writeMatches(bag_, kMatches, 2.5, all);
  writeMatches(bag_, kSelected, 2.5, all.subset({0, 1}));
  writeInfos(bag_);
  const auto source = open();
  ASSERT_EQ(source->size(), 1U);
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.id, (core::PairId{"drive", "bag", "2.500000000"}));
  ASSERT_TRUE(pair.given);
  EXPECT_EQ(pair.given->left_x, all.left_x);
  EXPECT_TRUE(pair.left.empty());
  EXPECT_TRUE(hasNote(*source, "the matches are those on /correspondences"));
  EXPECT_FALSE(source->next(pair));
}

TEST_F(RecordedBag, ATopicCanBeChosen) {
  const core::Correspondences all = sceneMatches(true);
  writeMatches(bag_, kMatches, 1, all);
  writeMatches(bag_, kSelected, 1, all.subset({0, 1}));
  BagTopics topics;
  topics.correspondences = "matches";
  const auto source = open(topics);
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.given->size(), 2U);
}

TEST_F(RecordedBag, TopicsThatCannotBeToldApartAreRefused) {
  writeMatches(bag_, "/front/correspondences", 1, sceneMatches(true));
  writeMatches(bag_, "/rear/correspondences", 1, sceneMatches(true));
  EXPECT_NE(refusal().find(
                "/front/correspondences, /rear/correspondences: name the topic to use by correspondences"),
            std::string::npos);
  BagTopics topics;
  topics.correspondences = "/nothing";
  EXPECT_NE(refusal(topics).find("has no corrsel/Correspondences on /nothing"), std::string::npos);
}

TEST_F(RecordedBag, MatchesOfRectifiedImagesAreEvaluatedAsTheyAre) {
  const core::Correspondences matches = sceneMatches(true);
  writeMatches(bag_, kMatches, 1, matches);
  writeInfos(bag_);
  const auto source = open();
  EXPECT_TRUE(hasNote(*source, "taken to be of rectified images: 100 % of them"));
  EXPECT_NE(source->evaluatedByCalibration().find("1 of 1 pair is evaluated with camera_info"),
            std::string::npos);
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.given->right_x, matches.right_x);
  ASSERT_EQ(pair.truth.kind, core::TruthKind::kFundamental);
  for (const double error : core::groundTruthErrors(pair.truth, *pair.given)) EXPECT_LT(error, 1e-3);
}

TEST_F(RecordedBag, MatchesOfRawImagesAreUndistortedAndRectified) {
  core::Correspondences matches = sceneMatches(false);
  matches.right_x[7] = 900;  // far beyond the image
  for (std::size_t i = 0; i < matches.size(); ++i) {
    matches.distance.push_back(static_cast<float>(i));
    matches.left_frame.push_back({3, 0, matches.left_x[i], 0, 3, matches.left_y[i]});
  }
  writeMatches(bag_, kMatches, 1, matches);
  writeInfos(bag_);
  const auto source = open();
  EXPECT_TRUE(hasNote(*source, "taken to be of raw images: 100 % of them")) << source->notes()[1];
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  ASSERT_TRUE(pair.given);
  const core::Correspondences& seen = *pair.given;
  ASSERT_EQ(seen.size(), matches.size() - 1) << "only the one beyond the image is left out";
  EXPECT_EQ(seen.distance[7], 8) << "columns stay together";
  EXPECT_EQ(seen.left_size, rig(false).leftArea().size());
  for (const double error : core::groundTruthErrors(pair.truth, seen)) EXPECT_LT(error, 0.05);
  const core::Correspondences expected = sceneMatches(true);
  const cv::Point corner = rig(false).leftArea().tl();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto from = static_cast<std::size_t>(seen.distance[i]);
    EXPECT_NEAR(seen.left_x[i] + static_cast<float>(corner.x), expected.left_x[from], 0.05);
    EXPECT_NEAR(seen.left_y[i] + static_cast<float>(corner.y), expected.left_y[from], 0.05);
    EXPECT_EQ(seen.left_frame[i][2], seen.left_x[i]);
    EXPECT_NEAR(seen.left_frame[i][0], 3 * 0.96, 1.5) << "near the scale of P to K, more at the corners";
  }
}

TEST_F(RecordedBag, ImagesSaysWhatTheMatchesAreOf) {
  writeMatches(bag_, kMatches, 1, sceneMatches(true));
  writeInfos(bag_);
  BagTopics topics;
  topics.images = "raw";
  const auto source = open(topics);
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.given->left_size, rig(false).leftArea().size());
  topics.images = "cooked";
  EXPECT_THROW(openBag(path(), topics), std::invalid_argument);
}

TEST_F(RecordedBag, AWrongDeclarationOfTheImagesIsNoticed) {
  for (const bool are_rectified : {false, true}) {
    SCOPED_TRACE(are_rectified);
    writeMatches(bag_, kMatches, 1, sceneMatches(are_rectified, 300));
    writeInfos(bag_);
    for (const bool declared_rectified : {false, true}) {
      BagTopics topics;
      topics.images = declared_rectified ? "rectified" : "raw";
      const auto source = open(topics);
      core::ImagePair pair;
      ASSERT_TRUE(source->next(pair));
      const std::vector<core::TruthWarning> warnings =
          core::truthWarnings(core::checkTruth(pair.truth, pair.other_readings, *pair.given));
      if (declared_rectified == are_rectified) {
        EXPECT_TRUE(warnings.empty());
        continue;
      }
      ASSERT_EQ(warnings.size(), 1U);
      EXPECT_EQ(warnings[0].counts.reading, are_rectified ? "rectified" : "raw");
      EXPECT_GT(warnings[0].counts.n_reading, 0.95 * static_cast<double>(warnings[0].counts.n_putative));
    }
    bag_.open(path(), rosbag::bagmode::Write);
  }
}

TEST_F(RecordedBag, GroundTruthComesFirst) {
  const core::Correspondences matches = sceneMatches(false);
  writeMatches(bag_, kMatches, 1, matches);
  writeMatches(bag_, kMatches, 2, matches);
  writeInfos(bag_);
  GroundTruth truth;
  truth.header.stamp = ros::Time(2);
  truth.kind = GroundTruth::KIND_HOMOGRAPHY;
  truth.matrix = {1, 0, 5, 0, 1, 0, 0, 0, 1};
  bag_.write("/ground_truth", ros::Time(2), truth);
  const auto source = open();
  EXPECT_TRUE(hasNote(*source, "1 of 2 pairs are evaluated with /ground_truth"));
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.truth.kind, core::TruthKind::kFundamental);
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.truth.kind, core::TruthKind::kHomography);
  EXPECT_EQ(pair.given->left_x, matches.left_x) << "truth is about the images as they were matched";
}

TEST_F(RecordedBag, WithoutTruthMatchesAreStillGiven) {
  writeMatches(bag_, kMatches, 1, sceneMatches(true));
  const auto source = open();
  EXPECT_TRUE(hasNote(*source, "no precision and no recall"));
  EXPECT_TRUE(hasNote(*source, "there is no camera_info"));
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.truth.kind, core::TruthKind::kNone);
  EXPECT_EQ(pair.given->size(), 60U);
}

TEST_F(RecordedBag, ASequenceIsNotEvaluatedWithTheRig) {
  writeMatches(bag_, kMatches, 2, sceneMatches(true), 1.9);
  writeInfos(bag_);
  const auto source = open();
  EXPECT_TRUE(hasNote(*source, "not taken at the same time (within 0.01 s)"));
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.truth.kind, core::TruthKind::kNone);
}

TEST_F(RecordedBag, CamerasAreToldApartByFrameIds) {
  writeMatches(bag_, kMatches, 1, sceneMatches(true));
  writeInfos(bag_, "/cam1/camera_info", "/cam0/camera_info");
  EXPECT_NE(open()->evaluatedByCalibration().find("on /cam1/camera_info and /cam0/camera_info"),
            std::string::npos);
}

TEST_F(RecordedBag, CamerasCanBeNamed) {
  Correspondences message = recorded(1, sceneMatches(true));
  message.right_frame_id = message.header.frame_id;
  bag_.write(kMatches, ros::Time(1), message);
  writeInfos(bag_, "/cam1/camera_info", "/cam0/camera_info");
  EXPECT_TRUE(hasNote(*open(), "name them by left_info and right_info"));
  BagTopics topics;
  topics.left_info = "/cam1/camera_info";
  topics.right_info = "cam0/camera_info";
  EXPECT_NE(openBag(path(), topics)->evaluatedByCalibration().find("1 of 1 pair is evaluated with"),
            std::string::npos);
  topics.right_info = "/elsewhere";
  EXPECT_NE(refusal(topics).find("has no sensor_msgs/CameraInfo for right on /elsewhere"), std::string::npos);
}

TEST_F(RecordedBag, CameraInfoOfAnotherSizeIsNoGroundTruth) {
  core::Correspondences matches = sceneMatches(true);
  matches.left_size = {320, 240};
  writeMatches(bag_, kMatches, 1, matches);
  writeInfos(bag_);
  EXPECT_TRUE(hasNote(*open(), "the matches are of images of 320x240 px"));
}

TEST_F(RecordedBag, AMessageThatMakesNoSenseCostsItsPairOnly) {
  Correspondences broken = recorded(1, sceneMatches(true));
  broken.left_y.pop_back();
  bag_.write(kMatches, ros::Time(1), broken);
  writeMatches(bag_, kMatches, 2, sceneMatches(true));
  writeInfos(bag_);
  BagTopics topics;
  topics.images = "rectified";
  bag_.close();
  const auto source = openBag(path(), topics);
  ASSERT_EQ(source->size(), 2U);
  core::ImagePair pair;
  EXPECT_THROW(source->next(pair), core::DatasetError);
  EXPECT_TRUE(source->next(pair));
}

TEST_F(RecordedBag, MatchesOfAnotherVersionAreRefusedWithTheRemedy) {
  OtherVersion message;
  message.header.stamp = ros::Time(1);
  bag_.write(kMatches, ros::Time(1), message);
  const std::string text = refusal();
  for (const char* part : {"no message on /correspondences that can be read",
                           "1 message of another version of corrsel/Correspondences", "rosbag fix",
                           "record the matches again"}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST_F(RecordedBag, ACutOffRecordingSaysWhatToDo) {
  for (int i = 1; i < 50; ++i) writeMatches(bag_, kMatches, i, sceneMatches(true));
  bag_.close();
  fs::resize_file(path(), fs::file_size(path()) / 2);
  EXPECT_NE(refusal().find("run: rosbag reindex " + path()), std::string::npos);
}

TEST(StereoRigPoints, AreTheInverseOfTheLens) {
  const StereoRig raw = rig(false);
  for (const bool right : {false, true}) {
    const sensor_msgs::CameraInfo info = cameraInfo(right);
    const cv::Point corner = (right ? raw.rightArea() : raw.leftArea()).tl();
    const auto rectify = [&](const std::vector<cv::Point2f>& points) {
      return right ? raw.rectifyRight(points) : raw.rectifyLeft(points);
    };
    std::vector<cv::Point2f> points, expected;
    for (double x = -0.4; x <= 0.4; x += 0.1) {
      for (double y = -0.3; y <= 0.3; y += 0.1) {
        points.push_back(seenBy(info, {x, y, 1}));
        expected.push_back(rectifiedBy(info, {x, y, 1}) - cv::Point2f(corner));
      }
    }
    const std::vector<cv::Point2f> back = right ? raw.recordedRight(expected) : raw.recordedLeft(expected);
    const std::vector<cv::Matx23d> maps = rectify(points);
    ASSERT_EQ(back.size(), points.size());
    const std::vector<cv::Point2f> positions = right ? raw.positionsRight(points) : raw.positionsLeft(points);
    ASSERT_EQ(positions.size(), points.size());
    ASSERT_EQ(maps.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(maps[i](0, 2), expected[i].x, 0.02);
      EXPECT_NEAR(maps[i](1, 2), expected[i].y, 0.02);
      EXPECT_LT(cv::norm(back[i] - points[i]), 0.02);
      EXPECT_EQ(positions[i], cv::Point2f(cv::Point2d(maps[i](0, 2), maps[i](1, 2))));
      // The derivative predicts where a nearby point goes.
      const std::vector<cv::Matx23d> beside = rectify({points[i] + cv::Point2f(1, 2)});
      EXPECT_NEAR(beside[0](0, 2), maps[i](0, 2) + maps[i](0, 0) + 2 * maps[i](0, 1), 0.03);
      EXPECT_NEAR(beside[0](1, 2), maps[i](1, 2) + maps[i](1, 0) + 2 * maps[i](1, 1), 0.03);
    }
  }
  EXPECT_TRUE(std::isnan(raw.rectifyLeft(std::vector<cv::Point2f>{{5000, 5000}})[0](0, 2)));
  EXPECT_TRUE(std::isnan(raw.positionsLeft({{5000, 5000}})[0].x));
  EXPECT_TRUE(raw.rectifyLeft(std::vector<cv::Point2f>()).empty());
  const cv::Matx23d same = rig(true).rectifyRight(std::vector<cv::Point2f>{{12, 34}})[0];
  EXPECT_EQ(same, cv::Matx23d(1, 0, 12, 0, 1, 34));
  EXPECT_EQ(rig(true).recordedRight({{12, 34}}), (std::vector<cv::Point2f>{{12, 34}}));
}

}  // namespace
}  // namespace corrsel
