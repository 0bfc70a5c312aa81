#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/String.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/truth_check.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/dataset_bag_writer.h"
#include "ros/bags/open_bag.h"
#include "ros/bags/stereo_rig.h"
#include "test_paths.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr char kLeft[] = "/stereo/left/image_raw", kRight[] = "/stereo/right/image_raw",
               kLeftInfo[] = "/stereo/left/camera_info", kRightInfo[] = "/stereo/right/camera_info";
constexpr int kWidth = 64, kHeight = 48;

/// An image whose every pixel has the value.
cv::Mat plain(int value, int width = kWidth, int height = kHeight) {
  return {height, width, CV_8UC1, cv::Scalar(value)};
}

void writeImage(rosbag::Bag& bag, const std::string& topic, double stamp, const cv::Mat& image,
                double recorded = 0) {
  std_msgs::Header header;
  if (stamp > 0) header.stamp = ros::Time(stamp);
  bag.write(topic, ros::Time(recorded > 0 ? recorded : stamp),
            *cv_bridge::CvImage(header, "mono8", image).toImageMsg());
}

void writeCompressed(rosbag::Bag& bag, const std::string& topic, double stamp, const cv::Mat& image) {
  std_msgs::Header header;
  header.stamp = ros::Time(stamp);
  bag.write(topic + "/compressed", header.stamp, toPngMsg(header, image));
}

/// Half of a rig with a baseline of 0.1 m and a weak lens.
sensor_msgs::CameraInfo cameraInfo(bool right) {
  sensor_msgs::CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = "plumb_bob";
  info.D = {0.05, 0, 0, 0, 0};
  info.K = {50, 0, 32, 0, 50, 24, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {50, 0, 32, right ? -5.0 : 0.0, 0, 50, 24, 0, 0, 0, 1, 0};
  return info;
}

void writeInfos(rosbag::Bag& bag, double stamp = 1.0) {
  bag.write(kLeftInfo, ros::Time(stamp), cameraInfo(false));
  bag.write(kRightInfo, ros::Time(stamp), cameraInfo(true));
}

void writeTruth(rosbag::Bag& bag, const std::string& topic, double stamp, double shift = 0) {
  GroundTruth truth;
  truth.header.stamp = ros::Time(stamp);
  truth.kind = GroundTruth::KIND_HOMOGRAPHY;
  truth.matrix = {1, 0, shift, 0, 1, 0, 0, 0, 1};
  bag.write(topic, truth.header.stamp, truth);
}

BagTopics stereoTopics() {
  BagTopics topics;
  topics.left = kLeft;
  topics.right = kRight;
  return topics;
}

class OwnBag : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("corrsel_test_own_bag_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    path_ = (folder_ / "robot.bag").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void record(const std::function<void(rosbag::Bag&)>& action) {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    action(bag);
    bag.close();
  }

  /// A bag of `n` pairs at 10 Hz from 1 s on; images have the value 10 i, right ones 1 more.
  void recordStereo(int n, const std::function<void(rosbag::Bag&)>& more = nullptr) {
    record([&](rosbag::Bag& bag) {
      for (int i = 1; i <= n; ++i) {
        writeImage(bag, kLeft, 0.9 + 0.1 * i, plain(10 * i));
        writeImage(bag, kRight, 0.9 + 0.1 * i, plain(10 * i + 1));
      }
      if (more) more(bag);
    });
  }

  static std::string errorOf(const std::function<void()>& action) {
    try {
      action();
    } catch (const core::DatasetError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no core::DatasetError";
    return "";
  }

  std::string openError(const BagTopics& topics = stereoTopics()) {
    return errorOf([&] { openBag(path_, topics); });
  }

  static void expectContains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }

  /// All pairs; their number must be size().
  static std::vector<core::ImagePair> readAll(core::PairSource& source) {
    std::vector<core::ImagePair> pairs;
    core::ImagePair pair;
    while (source.next(pair)) pairs.push_back(pair);
    EXPECT_EQ(pairs.size(), source.size());
    EXPECT_FALSE(source.next(pair));
    return pairs;
  }

  static int middle(const cv::Mat& image) { return image.at<std::uint8_t>(image.rows / 2, image.cols / 2); }

  fs::path folder_;
  std::string path_;
};

TEST_F(OwnBag, CalibrationIsTheTruth) {
  recordStereo(3, [](rosbag::Bag& bag) { writeInfos(bag); });
  const auto source = openBag(path_, stereoTopics());
  EXPECT_EQ(source->size(), 3u);
  EXPECT_TRUE(source->notes().empty()) << source->notes().front();
  const std::vector<core::ImagePair> pairs = readAll(*source);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].id.text(), "robot/bag/1.000000000");
  EXPECT_EQ(pairs[2].id.text(), "robot/bag/1.200000000");
  for (int i = 0; i < 3; ++i) {
    const core::ImagePair& pair = pairs[static_cast<std::size_t>(i)];
    EXPECT_EQ(middle(pair.left), 10 * (i + 1));
    EXPECT_EQ(middle(pair.right), 10 * (i + 1) + 1);
    ASSERT_EQ(pair.truth.kind, core::TruthKind::kFundamental);
    core::Correspondences matches;
    matches.add({30, 20}, {25, 20});
    matches.add({30, 20}, {25, 23});
    const std::vector<double> errors = core::groundTruthErrors(pair.truth, matches);
    EXPECT_NEAR(errors[0], 0.0, 1e-6);
    EXPECT_NEAR(errors[1], 3.0, 1e-6);
    EXPECT_FALSE(pair.given);
  }
}

TEST_F(OwnBag, PairsThatTheCalibrationEvaluatesAreCounted) {
  recordStereo(3, [](rosbag::Bag& bag) {
    writeInfos(bag);
    writeTruth(bag, "/ground_truth", 1.0);
  });
  expectContains(openBag(path_, stereoTopics())->evaluatedByCalibration(),
                 "2 of 3 pairs are evaluated with camera_info on /stereo/left/camera_info and "
                 "/stereo/right/camera_info");
  recordStereo(1, [](rosbag::Bag& bag) { writeTruth(bag, "/ground_truth", 1.0); });
  EXPECT_EQ(openBag(path_, stereoTopics())->evaluatedByCalibration(), "");
}

TEST_F(OwnBag, ImagesThatUseFewerThanSixteenBitsAreStretchedAlike) {
  for (const bool compressed : {false, true}) {
    for (const int largest : {4095, 65535}) {
      record([&](rosbag::Bag& bag) {
        std_msgs::Header header;
        header.stamp = ros::Time(1.0);
        for (const char* topic : {kLeft, kRight}) {
          const cv::Mat pixels(kHeight, kWidth, CV_16UC1, cv::Scalar(topic == kLeft ? largest : 1000));
          if (compressed) {
            writeCompressed(bag, topic, 1.0, pixels);
          } else {
            bag.write(topic, header.stamp, *cv_bridge::CvImage(header, "mono16", pixels).toImageMsg());
          }
        }
        writeTruth(bag, "/ground_truth", 1.0);
      });
      core::ImagePair pair;
      ASSERT_TRUE(openBag(path_, stereoTopics())->next(pair));
      EXPECT_EQ(middle(pair.left), 255);
      EXPECT_EQ(pair.stretched.has_value(), largest == 4095);
      if (!pair.stretched) {
        EXPECT_NEAR(middle(pair.right), 1000 / 257.0, 1);
        continue;
      }
      EXPECT_EQ(middle(pair.right), std::lround(1000 * 255 / 4095.0));
      expectContains(pair.stretched->text(), "use 12 of them (values up to 4095 in /stereo/left/image_raw");
    }
  }
}

TEST_F(OwnBag, RawImagesAreRectifiedAndRectifiedOnesAreNot) {
  const auto pairOf = [this](const std::string& name, const std::string& images) {
    record([&](rosbag::Bag& bag) {
      // Lines that the lens has bent stay bent unless the image is rectified.
      cv::Mat image = plain(0);
      image.row(3).setTo(255);
      writeImage(bag, "/stereo/left/" + name, 1, image);
      writeImage(bag, "/stereo/right/" + name, 1, image);
      writeInfos(bag);
    });
    BagTopics topics;
    topics.left = "/stereo/left/" + name;
    topics.right = "/stereo/right/" + name;
    topics.images = images;
    const auto source = openBag(path_, topics);
    core::ImagePair pair;
    EXPECT_TRUE(source->next(pair));
    const bool changed =
        cv::countNonZero(pair.left != pair.right) > 0 || pair.left.at<std::uint8_t>(3, 2) != 255;
    EXPECT_EQ(pair.truth.kind, core::TruthKind::kFundamental);
    return changed;
  };
  EXPECT_TRUE(pairOf("image_raw", "auto"));
  EXPECT_FALSE(pairOf("image_rect", "auto"));
  EXPECT_FALSE(pairOf("image_rect_color", "auto"));
  EXPECT_FALSE(pairOf("image_raw", "rectified"));
  EXPECT_TRUE(pairOf("image_rect", "raw"));
}

TEST_F(OwnBag, CompressedImagesAndNamesOfTopics) {
  record([](rosbag::Bag& bag) {
    writeCompressed(bag, kLeft, 1, plain(10));
    writeCompressed(bag, kRight, 1, plain(11));
    writeInfos(bag);
  });
  for (const std::string name :
       {"/stereo/%/image_raw", "/stereo/%/image_raw/compressed", "stereo/%/image_raw"}) {
    SCOPED_TRACE(name);
    const auto side = [&name](const std::string& value) {
      std::string topic = name;
      return topic.replace(topic.find('%'), 1, value);
    };
    BagTopics topics;
    topics.left = side("left");
    topics.right = side("right");
    const auto source = openBag(path_, topics);
    core::ImagePair pair;
    ASSERT_TRUE(source->next(pair));
    EXPECT_EQ(middle(pair.left), 10);
    EXPECT_EQ(middle(pair.right), 11);
  }
  recordStereo(1, [](rosbag::Bag& bag) { writeInfos(bag); });  // raw, asked for as compressed
  BagTopics topics;
  topics.left = std::string(kLeft) + "/compressed";
  topics.right = kRight;
  EXPECT_EQ(openBag(path_, topics)->size(), 1u);
}

TEST_F(OwnBag, NamedCameraInfo) {
  recordStereo(1, [](rosbag::Bag& bag) {
    bag.write("/calibration/a", ros::Time(1), cameraInfo(false));
    bag.write("/calibration/b", ros::Time(1), cameraInfo(true));
  });
  BagTopics topics = stereoTopics();
  topics.left_info = "/calibration/a";
  topics.right_info = "calibration/b";
  EXPECT_EQ(readAll(*openBag(path_, topics)).size(), 1u);
  topics.right_info = "/calibration/c";
  const std::string error = openError(topics);
  expectContains(error, "no sensor_msgs/CameraInfo for right on /calibration/c");
  expectContains(error, "/calibration/b (sensor_msgs/CameraInfo)");
}

TEST_F(OwnBag, NearestStampsWithinTheTolerance) {
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    // left:  1.000        1.100   1.105   1.200   1.300
    // right: 1.004 1.007          1.104           1.311
    writeImage(bag, kLeft, 1.000, plain(10), 2);
    writeImage(bag, kLeft, 1.100, plain(20), 2);
    writeImage(bag, kLeft, 1.105, plain(30), 2);
    writeImage(bag, kLeft, 1.200, plain(40), 2);
    writeImage(bag, kLeft, 1.300, plain(50), 2);
    writeImage(bag, kRight, 1.311, plain(51), 1.5);  // recorded before, and in another order
    writeImage(bag, kRight, 1.104, plain(31), 2.5);
    writeImage(bag, kRight, 1.007, plain(12), 3);
    writeImage(bag, kRight, 1.004, plain(11), 3);
  });
  const auto source = openBag(path_, stereoTopics());
  const std::vector<core::ImagePair> pairs = readAll(*source);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].id.pair, "1.000000000");
  EXPECT_EQ(middle(pairs[0].right), 11);
  EXPECT_EQ(pairs[1].id.pair, "1.105000000");
  EXPECT_EQ(middle(pairs[1].right), 31);
  ASSERT_EQ(source->notes().size(), 1u);
  EXPECT_EQ(source->notes()[0], "3 of 5 left images have no right image within 0.01 s and are left out");

  BagTopics wider = stereoTopics();
  wider.max_stamp_difference = 0.02;
  EXPECT_EQ(readAll(*openBag(path_, wider)).size(), 3u);
}

TEST_F(OwnBag, EqualStampsArePairedOnce) {
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    for (const int value : {10, 20}) writeImage(bag, kLeft, 1, plain(value));
    for (const int value : {11, 21}) writeImage(bag, kRight, 1, plain(value));
  });
  const auto source = openBag(path_, stereoTopics());
  const std::vector<core::ImagePair> pairs = readAll(*source);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(middle(pairs[0].left), 10);
  EXPECT_EQ(middle(pairs[0].right), 11);
}

TEST_F(OwnBag, ImagesWithoutStampCountWithTheTimeOfRecording) {
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    for (int i = 1; i <= 2; ++i) {
      writeImage(bag, kLeft, 0, plain(10 * i), i);
      writeImage(bag, kRight, 0, plain(10 * i + 1), i + 0.003);
    }
  });
  const auto source = openBag(path_, stereoTopics());
  const std::vector<core::ImagePair> pairs = readAll(*source);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[1].id.pair, "2.000000000");
  ASSERT_EQ(source->notes().size(), 2u);
  expectContains(source->notes()[0], "2 messages on " + std::string(kLeft) + " have no stamp");
}

TEST_F(OwnBag, GroundTruthWinsOverCalibration) {
  recordStereo(3, [](rosbag::Bag& bag) {
    writeInfos(bag);
    writeTruth(bag, "/ground_truth", 1.1, 7);
    writeTruth(bag, "/ground_truth", 5.0);
  });
  const auto source = openBag(path_, stereoTopics());
  const std::vector<core::ImagePair> pairs = readAll(*source);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].truth.kind, core::TruthKind::kFundamental);
  EXPECT_EQ(pairs[1].truth.kind, core::TruthKind::kHomography);
  EXPECT_EQ(pairs[1].truth.matrix(0, 2), 7.0);
  EXPECT_EQ(pairs[1].id.text(), "robot/bag/1.100000000");
  EXPECT_EQ(cv::countNonZero(pairs[1].left != 20), 0) << "rectified, though the truth is of the raw images";
  EXPECT_EQ(pairs[1].left.size(), cv::Size(kWidth, kHeight));
  EXPECT_NE(pairs[0].left.size(), cv::Size(kWidth, kHeight)) << "not rectified and cut";
  ASSERT_EQ(source->notes().size(), 2u);
  EXPECT_EQ(source->notes()[0], "1 of 3 pairs are evaluated with /ground_truth, the others with camera_info");
  EXPECT_EQ(source->notes()[1], "1 of 2 messages on /ground_truth belong to no pair");
}

TEST_F(OwnBag, GroundTruthAlone) {
  recordStereo(3, [](rosbag::Bag& bag) {
    writeTruth(bag, "/target/truth", 1.0, 1);
    writeTruth(bag, "/target/truth", 1.205, 2);  // within the tolerance
  });
  BagTopics topics = stereoTopics();
  topics.ground_truth = "/target/truth";
  const auto source = openBag(path_, topics);
  const std::vector<core::ImagePair> pairs = readAll(*source);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[1].id.pair, "1.200000000");
  EXPECT_EQ(pairs[1].truth.matrix(0, 2), 2.0);
  ASSERT_EQ(source->notes().size(), 1u);
  expectContains(source->notes()[0],
                 "1 of 3 pairs have no message on /target/truth and are left out, since there "
                 "is no camera_info on /stereo/left/camera_info and /stereo/right/camera_info");
  topics.ground_truth = "/truth";
  expectContains(openError(topics), "no corrsel/GroundTruth on /truth");
}

TEST_F(OwnBag, GroundTruthOfAnotherTypeIsNotLookedAt) {
  recordStereo(1, [](rosbag::Bag& bag) {
    writeInfos(bag);
    bag.write("/ground_truth", ros::Time(1), std_msgs::String());
  });
  const auto source = openBag(path_, stereoTopics());
  EXPECT_EQ(source->size(), 1u);
  ASSERT_EQ(source->notes().size(), 1u);
  expectContains(source->notes()[0], "/ground_truth is std_msgs/String");
}

TEST_F(OwnBag, BrokenGroundTruthCostsItsPair) {
  recordStereo(2, [](rosbag::Bag& bag) {
    GroundTruth truth;
    truth.header.stamp = ros::Time(1.0);
    truth.kind = 77;
    bag.write("/ground_truth", ros::Time(1), truth);
    writeTruth(bag, "/ground_truth", 1.1);
  });
  const auto source = openBag(path_, stereoTopics());
  core::ImagePair pair;
  const std::string error = errorOf([&] { source->next(pair); });
  expectContains(error, "robot/bag/1.000000000: /ground_truth: GroundTruth message: kind");
  EXPECT_EQ(pair.id.text(), "robot/bag/1.000000000");
  EXPECT_TRUE(source->next(pair));
  EXPECT_FALSE(source->next(pair));
}

TEST_F(OwnBag, TopicsOfADatasetBagWithCameraInfo) {
  const auto pairOf = [this](bool with_truth) {
    record([with_truth](rosbag::Bag& bag) {
      writeImage(bag, bag_topics::kLeft, 1, plain(10));
      writeImage(bag, bag_topics::kRight, 1.004, plain(11));
      bag.write("/left/camera_info", ros::Time(1), cameraInfo(false));
      bag.write("/right/camera_info", ros::Time(1), cameraInfo(true));
      if (with_truth) writeTruth(bag, "/ground_truth", 1);
    });
    BagTopics topics;
    if (with_truth) topics.ground_truth = "/ground_truth";  // else nothing is named
    const auto source = openBag(path_, topics);
    core::ImagePair pair;
    EXPECT_TRUE(source->next(pair));
    return pair;
  };
  EXPECT_EQ(pairOf(false).truth.kind, core::TruthKind::kFundamental);
  EXPECT_EQ(pairOf(true).truth.kind, core::TruthKind::kHomography);
}

TEST_F(OwnBag, AbsentTopicsAreListed) {
  recordStereo(1, [](rosbag::Bag& bag) {
    writeInfos(bag);
    bag.write("/chatter", ros::Time(1), std_msgs::String());
  });
  BagTopics topics = stereoTopics();
  topics.right = "/stereo/rigth/image_raw";
  const std::string error = openError(topics);
  expectContains(error, "no images for right on /stereo/rigth/image_raw");
  expectContains(error, "/stereo/right/image_raw (sensor_msgs/Image)");
  expectContains(error, "/chatter (std_msgs/String)");
  topics.right = "/chatter";  // there, but not images
  expectContains(openError(topics), "no images for right on /chatter");
  topics.right = "";  // that of a dataset bag
  expectContains(openError(topics), "no images for right on /right/image");
}

TEST_F(OwnBag, LeftAndRightAreOneTopic) {
  recordStereo(1, [](rosbag::Bag& bag) {
    writeInfos(bag);
    writeCompressed(bag, kLeft, 1, plain(10));
  });
  BagTopics topics = stereoTopics();
  topics.right = kLeft;
  expectContains(openError(topics), "left and right are both /stereo/left/image_raw");
  topics.right = std::string(kLeft) + "/compressed";
  expectContains(openError(topics), "left and right are both /stereo/left/image_raw");
}

TEST_F(OwnBag, StampsTooFarApart) {
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    writeImage(bag, kLeft, 1.0, plain(10));
    writeImage(bag, kRight, 1.25, plain(11));
    writeImage(bag, kRight, 1.5, plain(11));
  });
  std::string error = openError();
  expectContains(error, "no image on /stereo/right/image_raw comes within 0.01 s");
  expectContains(error, "smallest difference of stamps is 0.25 s: set max_stamp_difference");
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    writeImage(bag, kLeft, 1.0, plain(10));
    writeImage(bag, kRight, 1000.0, plain(11));
  });
  error = openError();
  expectContains(error, "difference of stamps is 999 s: are the clocks");
}

TEST_F(OwnBag, NoGroundTruth) {
  recordStereo(1);
  std::string error = openError();
  expectContains(error,
                 "no ground truth: there is no camera_info on /stereo/left/camera_info and "
                 "/stereo/right/camera_info; and there is no corrsel/GroundTruth on /ground_truth");
  expectContains(error, "/stereo/left/image_raw (sensor_msgs/Image)");
  recordStereo(1, [](rosbag::Bag& bag) { writeTruth(bag, "/ground_truth", 3.5); });
  expectContains(openError(),
                 "no message on /ground_truth has the stamp of a left image (the smallest "
                 "difference is 2.5 s)");
}

TEST_F(OwnBag, CameraInfoOfOneSideOnly) {
  recordStereo(1, [](rosbag::Bag& bag) { bag.write(kRightInfo, ros::Time(1), cameraInfo(true)); });
  expectContains(openError(),
                 "no camera_info on /stereo/left/camera_info, while /stereo/right/camera_info has one");
}

TEST_F(OwnBag, UnusableCalibration) {
  const auto errorWith = [this](const std::function<void(sensor_msgs::CameraInfo&)>& change) {
    recordStereo(1, [&](rosbag::Bag& bag) {
      sensor_msgs::CameraInfo info = cameraInfo(true);
      change(info);
      bag.write(kLeftInfo, ros::Time(1), cameraInfo(false));
      bag.write(kRightInfo, ros::Time(1), info);
    });
    return openError();
  };
  expectContains(errorWith([](sensor_msgs::CameraInfo& info) { info = sensor_msgs::CameraInfo(); }),
                 "no ground truth: camera_info on /stereo/right/camera_info is all zero: the camera is not "
                 "calibrated; calibrate both cameras together");
  expectContains(errorWith([](sensor_msgs::CameraInfo& info) { info.P[3] = 0; }), "a baseline of zero");
  expectContains(errorWith([](sensor_msgs::CameraInfo& info) { info.P.fill(0); }), "has K but no P");
  expectContains(errorWith([](sensor_msgs::CameraInfo& info) { info.distortion_model = "fov"; }),
                 "distortion model 'fov'");
}

TEST_F(OwnBag, ImagesOfAnotherSizeThanCameraInfo) {
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    writeImage(bag, kLeft, 1, plain(10));
    writeImage(bag, kRight, 1, plain(11, 32, 24));
  });
  const std::string error = openError();
  expectContains(error, "/stereo/right/image_raw: the image has 32x24 px");
  expectContains(error, "/stereo/right/camera_info is for 64x48 px");

  recordStereo(1, [](rosbag::Bag& bag) {  // only later in the bag
    writeInfos(bag);
    writeImage(bag, kLeft, 1.5, plain(10, 32, 24));
    writeImage(bag, kRight, 1.5, plain(11));
  });
  const auto source = openBag(path_, stereoTopics());
  EXPECT_EQ(source->size(), 2u);
  core::ImagePair pair;
  EXPECT_TRUE(source->next(pair));
  expectContains(errorOf([&] { source->next(pair); }),
                 "robot/bag/1.500000000: /stereo/left/image_raw: the image has");
  EXPECT_FALSE(source->next(pair));
}

TEST_F(OwnBag, ChangingCameraInfoIsNoted) {
  recordStereo(1, [](rosbag::Bag& bag) {
    writeInfos(bag, 1);
    sensor_msgs::CameraInfo changed = cameraInfo(true);
    changed.P[3] = -6;
    bag.write(kRightInfo, ros::Time(2), changed);
  });
  const auto source = openBag(path_, stereoTopics());
  ASSERT_EQ(source->notes().size(), 1u);
  EXPECT_EQ(source->notes()[0],
            "camera_info on /stereo/right/camera_info changes in the bag: its first message is used");
}

TEST_F(OwnBag, BrokenImageIsNamedAndTheNextPairRead) {
  record([](rosbag::Bag& bag) {
    writeInfos(bag);
    sensor_msgs::CompressedImage broken;
    broken.header.stamp = ros::Time(1);
    broken.format = "png";
    broken.data = {1, 2, 3};
    bag.write(std::string(kLeft) + "/compressed", ros::Time(1), broken);
    writeCompressed(bag, kRight, 1, plain(11));
    writeCompressed(bag, kLeft, 2, plain(20));
    writeCompressed(bag, kRight, 2, plain(21));
  });
  const auto source = openBag(path_, stereoTopics());
  EXPECT_EQ(source->size(), 2u);
  core::ImagePair pair;
  expectContains(
      errorOf([&] { source->next(pair); }),
      "robot/bag/1.000000000: /stereo/left/image_raw/compressed: compressed image of format 'png'");
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(middle(pair.left), 20);
  EXPECT_FALSE(source->next(pair));
}

TEST_F(OwnBag, DamagedChunkCostsPairsNotTheRun) {
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::LZ4);
    bag.setChunkThreshold(6000);  // a pair a chunk
    writeInfos(bag);
    cv::Mat noise(kHeight, kWidth, CV_8UC1);
    cv::theRNG().state = 1;
    for (int i = 1; i <= 20; ++i) {
      cv::randu(noise, 0, 255);
      writeImage(bag, kLeft, i, noise);
      writeImage(bag, kRight, i, noise);
    }
    bag.close();
  }
  {
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(fs::file_size(path_) / 2));
    file << std::string(64, '\xa5');
  }
  const auto source = openBag(path_, stereoTopics());
  EXPECT_GE(source->size(), 15u);
  EXPECT_LT(source->size(), 20u);
  ASSERT_FALSE(source->notes().empty());
  expectContains(source->notes()[0], "cannot be read");
  readAll(*source);
}

TEST_F(OwnBag, OptionsOutOfRange) {
  recordStereo(1, [](rosbag::Bag& bag) { writeInfos(bag); });
  BagTopics topics = stereoTopics();
  topics.images = "rectify";
  EXPECT_THROW(openBag(path_, topics), std::invalid_argument);
  for (const double value : {-0.1, 11.0, std::nan("")}) {
    topics = stereoTopics();
    topics.max_stamp_difference = value;
    EXPECT_THROW(openBag(path_, topics), std::invalid_argument);
  }
}

/// Of SIFT matches that pass the ratio test at 0.8, the share within 1.5 px of the truth.
class KittiBag : public OwnBag {
 protected:
  struct Share {
    std::size_t near = 0, all = 0;
    double value() const { return static_cast<double>(near) / static_cast<double>(all); }
  };

  /// @param checks  the rows of checkTruth() are appended
  static void count(const core::ImagePair& pair, Share& share, std::vector<core::TruthCheck>& checks) {
    const auto extractor = core::createExtractor("sift+sift");
    const core::Correspondences matches =
        core::matchFeatures(extractor->extract(pair.left, 2), extractor->extract(pair.right, 2), {}, 2);
    const std::vector<double> errors = core::groundTruthErrors(pair.truth, matches);
    for (core::TruthCheck check : core::checkTruth(pair.truth, pair.other_readings, matches)) {
      check.id = pair.id;
      checks.push_back(check);
    }
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (!(matches.distance[i] < 0.8F * matches.second_distance[i])) continue;
      ++share.all;
      share.near += errors[i] <= 1.5 ? 1 : 0;
    }
  }
};

TEST_F(KittiBag, MatchesLieOnTheEpipolarLinesOfTheRectifiedFrames) {
  const std::string data = testing::realDataDir() + "/kitti_stereo";
  if (!fs::is_directory(data)) GTEST_SKIP() << "no data in " << data;
  const std::string command = std::string("PATH=/usr/bin:/bin:$PATH ") + testing::sourceDir() +
                              "/scripts/kitti_to_bag.py '" + data + "' --every 9 --output '" + path_ + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;

  Share rectified, raw;
  std::vector<core::TruthCheck> checks, control_checks;
  const auto source = openBag(path_, stereoTopics());
  BagTopics untouched = stereoTopics();
  untouched.images = "rectified";  // a lie: they are raw
  const auto control = openBag(path_, untouched);
  EXPECT_EQ(source->size(), 5u);
  core::ImagePair pair;
  while (source->next(pair)) {
    EXPECT_EQ(pair.left.size(), pair.right.size());
    EXPECT_GE(pair.left.cols, 1220);  // KITTI's own rectified frames have 1224x370 px
    EXPECT_GE(pair.left.rows, 365);
    count(pair, rectified, checks);
    ASSERT_TRUE(control->next(pair));
    count(pair, raw, control_checks);
  }
  RecordProperty("rectified", std::to_string(rectified.value()));
  RecordProperty("raw", std::to_string(raw.value()));
  EXPECT_GT(rectified.all, 1000u);
  EXPECT_GE(rectified.value(), 0.95) << rectified.near << " of " << rectified.all;
  EXPECT_LT(raw.value(), 0.5) << raw.near << " of " << raw.all;
  EXPECT_TRUE(core::truthWarnings(checks).empty());
  const std::vector<core::TruthWarning> warnings = core::truthWarnings(control_checks);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].counts.reading, "raw");
  EXPECT_EQ(warnings[0].pairs, 5u);
}

}  // namespace
}  // namespace corrsel
