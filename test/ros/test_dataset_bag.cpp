#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/String.h>
#include <unistd.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/random.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/dataset_bag_writer.h"
#include "ros/bags/open_bag.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

cv::Mat noise(int width, int height, int type, std::uint64_t seed) {
  core::Random random(seed);
  cv::Mat image(height, width, type);
  for (int y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < image.elemSize() * static_cast<std::size_t>(width); ++x) {
      image.ptr(y)[x] = static_cast<std::uint8_t>(random.index(256));
    }
  }
  return image;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

core::ImagePair homographyPair() {
  core::ImagePair pair;
  pair.id = {"made_up", "scene", "1-2"};
  pair.left = noise(64, 48, CV_8UC3, 1);
  pair.right = noise(80, 32, CV_8UC1, 2);  // another size and another number of channels
  pair.truth.kind = core::TruthKind::kHomography;
  pair.truth.matrix = cv::Matx33d(1, 0.5, 3, 0, 1, -2, 1e-4, 0, 1);
  return pair;
}

core::ImagePair labelledPair() {
  core::ImagePair pair;
  pair.id = {"made_up", "scene", "1-3"};
  pair.left = noise(64, 48, CV_8UC1, 3);
  pair.right = noise(64, 48, CV_8UC1, 4);
  pair.truth.kind = core::TruthKind::kLabels;
  pair.truth.labels = {0, 1};
  pair.given.emplace();
  pair.given->add({1, 2}, {3, 4});
  pair.given->add({5, 6}, {7, 8});
  pair.given->left_size = pair.given->right_size = {64, 48};
  return pair;
}

/// A dataset in memory; the pair in the middle is broken.
class BrokenMiddle : public core::DatasetReader {
 public:
  std::size_t size() const override { return 3; }
  core::PairId id(std::size_t index) const override {
    return index == 0   ? homographyPair().id
           : index == 2 ? labelledPair().id
                        : core::PairId{"made_up", "broken", "x"};
  }
  core::ImagePair read(std::size_t index) const override {
    if (index == 1) throw core::DatasetError("img7.ppm is missing");
    return index == 0 ? homographyPair() : labelledPair();
  }
  std::vector<std::string> files() const override { return {}; }
  std::vector<std::string> remarks() const override { return {"one pair is left out"}; }
};

class DatasetBag : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("corrsel_test_dataset_bag_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    path_ = (folder_ / "made_up.bag").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::vector<core::ImagePair>& pairs, bool compressed = false) {
    DatasetBagOptions options;
    options.compressed = compressed;
    DatasetBagWriter writer(path_, options);
    for (const core::ImagePair& pair : pairs) writer.write(pair);
    writer.close();
  }

  /// A bag written message by message.
  void record(const std::function<void(rosbag::Bag&)>& action) {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    action(bag);
    bag.close();
  }

  /// The text of the core::DatasetError that the action throws.
  static std::string errorOf(const std::function<void()>& action) {
    try {
      action();
    } catch (const core::DatasetError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no core::DatasetError";
    return "";
  }

  std::string openError() {
    return errorOf([this] { openBag(path_); });
  }

  fs::path folder_;
  std::string path_;
};

void writeImage(rosbag::Bag& bag, const std::string& topic, const ros::Time& stamp,
                const std::string& encoding, const cv::Mat& image) {
  std_msgs::Header header;
  header.stamp = stamp;
  bag.write(topic, stamp, *cv_bridge::CvImage(header, encoding, image).toImageMsg());
}

TEST_F(DatasetBag, RoundTripRawAndCompressed) {
  for (const bool compressed : {false, true}) {
    SCOPED_TRACE(compressed);
    write({homographyPair(), labelledPair()}, compressed);
    EXPECT_FALSE(fs::exists(path_ + ".part"));
    const auto source = openBag(path_);
    EXPECT_EQ(source->size(), 2u);

    core::ImagePair pair;
    ASSERT_TRUE(source->next(pair));
    EXPECT_EQ(pair.id, homographyPair().id);
    EXPECT_TRUE(equal(pair.left, homographyPair().left));
    EXPECT_TRUE(equal(pair.right, homographyPair().right));
    EXPECT_EQ(pair.truth.kind, core::TruthKind::kHomography);
    EXPECT_EQ(pair.truth.matrix, homographyPair().truth.matrix);
    EXPECT_FALSE(pair.given);

    ASSERT_TRUE(source->next(pair));
    EXPECT_EQ(pair.id, labelledPair().id);
    EXPECT_TRUE(equal(pair.left, labelledPair().left));
    EXPECT_EQ(pair.truth.labels, labelledPair().truth.labels);
    ASSERT_TRUE(pair.given);
    EXPECT_EQ(pair.given->right_x, labelledPair().given->right_x);
    EXPECT_EQ(pair.given->left_size, labelledPair().given->left_size);

    EXPECT_FALSE(source->next(pair));
    EXPECT_FALSE(source->next(pair));
  }
}

TEST_F(DatasetBag, PairsOfMatchesNeedNoImages) {
  core::ImagePair matches = labelledPair();
  matches.id.pair = "matches";
  matches.left = matches.right = cv::Mat();
  core::ImagePair fundamental = matches;
  fundamental.id.pair = "fundamental";
  fundamental.truth = {};
  fundamental.truth.kind = core::TruthKind::kFundamental;
  fundamental.truth.matrix = cv::Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 0);
  // Alone they are read as recorded matches, beside others as pairs of a dataset bag.
  for (const bool alone : {true, false}) {
    SCOPED_TRACE(alone);
    std::vector<core::ImagePair> pairs = {matches, fundamental};
    if (!alone) pairs.insert(pairs.begin() + 1, {homographyPair(), labelledPair()});
    write(pairs);
    const auto source = openBag(path_);
    ASSERT_EQ(source->size(), pairs.size());
    for (const core::ImagePair& expected : pairs) {
      core::ImagePair pair;
      ASSERT_TRUE(source->next(pair));
      EXPECT_EQ(pair.id, expected.id);
      EXPECT_EQ(pair.left.empty(), expected.left.empty());
      EXPECT_EQ(pair.right.empty(), expected.right.empty());
      EXPECT_EQ(pair.truth.kind, expected.truth.kind);
      EXPECT_EQ(pair.truth.labels, expected.truth.labels);
      EXPECT_EQ(pair.truth.matrix, expected.truth.matrix);
      ASSERT_EQ(pair.given.has_value(), expected.given.has_value());
      if (pair.given) {
        EXPECT_EQ(pair.given->right_x, expected.given->right_x);
        EXPECT_EQ(pair.given->left_size, expected.given->left_size);
      }
    }
    core::ImagePair none;
    EXPECT_FALSE(source->next(none));
  }
  DatasetBagWriter writer(path_);
  core::ImagePair half = matches;
  half.left = labelledPair().left;
  EXPECT_NE(errorOf([&] { writer.write(half); }).find("right"), std::string::npos);
}

TEST_F(DatasetBag, NamesOfImagesSurvive) {
  core::ImagePair images = homographyPair(), both = labelledPair(), matches = labelledPair();
  matches.left = matches.right = cv::Mat();
  matches.id.pair = "matches";
  for (core::ImagePair* const pair : {&images, &both, &matches}) {
    pair->left_name = "db/1.jpg";
    pair->right_name = "query/night 2.jpg";
  }
  for (const std::vector<core::ImagePair>& pairs :
       {std::vector<core::ImagePair>{images, both}, std::vector<core::ImagePair>{matches}}) {
    write(pairs);
    const auto source = openBag(path_);
    for (core::ImagePair pair; source->next(pair);) {
      EXPECT_EQ(pair.left_name, "db/1.jpg") << pair.id.text();
      EXPECT_EQ(pair.right_name, "query/night 2.jpg") << pair.id.text();
    }
  }
  write({homographyPair()});
  core::ImagePair pair;
  ASSERT_TRUE(openBag(path_)->next(pair));
  EXPECT_EQ(pair.left_name, "") << "a camera is no image";
}

TEST_F(DatasetBag, DisparityAndUnknownTruthSurvive) {
  core::ImagePair unknown = homographyPair();
  unknown.truth = {};
  core::ImagePair disparity = homographyPair();
  disparity.id.pair = "disparity";
  disparity.truth.kind = core::TruthKind::kDisparity;
  disparity.truth.disparity = cv::Mat(48, 64, CV_32FC1, cv::Scalar(12.5));
  disparity.truth.disparity.at<float>(3, 4) = std::numeric_limits<float>::quiet_NaN();
  write({unknown, disparity});
  const auto source = openBag(path_);
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.truth.kind, core::TruthKind::kNone);
  EXPECT_EQ(pair.id, unknown.id);
  ASSERT_TRUE(source->next(pair));
  ASSERT_EQ(pair.truth.disparity.size(), cv::Size(64, 48));
  EXPECT_EQ(pair.truth.disparity.at<float>(0, 0), 12.5F);
  EXPECT_TRUE(std::isnan(pair.truth.disparity.at<float>(3, 4)));
}

TEST_F(DatasetBag, EqualInputGivesEqualFiles) {
  const auto content = [this] {
    write({homographyPair(), labelledPair()});
    std::ifstream file(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string first = content();
  EXPECT_FALSE(first.empty());
  EXPECT_TRUE(first == content());
}

TEST_F(DatasetBag, MessagesOfAPairShareStampAndTime) {
  write({homographyPair(), labelledPair()});
  rosbag::Bag bag(path_, rosbag::bagmode::Read);
  rosbag::View view(bag);
  EXPECT_EQ(view.size(), 7u);
  for (const rosbag::MessageInstance& message : view) {
    if (const auto image = message.instantiate<sensor_msgs::Image>()) {
      EXPECT_EQ(image->header.stamp, message.getTime());
      EXPECT_EQ(image->header.frame_id,
                message.getTopic() == bag_topics::kLeft ? "left_camera_optical" : "right_camera_optical");
    }
    EXPECT_TRUE(message.getTime() == ros::Time(1) || message.getTime() == ros::Time(1.5))
        << message.getTime();
  }
}

TEST_F(DatasetBag, UnfinishedFileGoesAway) {
  {
    DatasetBagWriter writer(path_);
    writer.write(homographyPair());
    EXPECT_TRUE(fs::exists(path_ + ".part"));
  }
  EXPECT_FALSE(fs::exists(path_ + ".part"));
  EXPECT_FALSE(fs::exists(path_));
}

TEST_F(DatasetBag, WriterRefusesNonsense) {
  DatasetBagOptions options;
  options.period = 0.0;
  EXPECT_THROW(DatasetBagWriter(path_, options), std::invalid_argument);
  EXPECT_THROW(DatasetBagWriter((folder_ / "no" / "such" / "folder.bag").string()), core::DatasetError);
  DatasetBagWriter writer(path_);
  core::ImagePair pair = homographyPair();
  pair.right = cv::Mat(4, 4, CV_32FC1, cv::Scalar(0));
  EXPECT_NE(errorOf([&] { writer.write(pair); }).find("right"), std::string::npos);
}

TEST_F(DatasetBag, ConversionSkipsBrokenPairs) {
  std::vector<UnreadablePair> problems;
  std::vector<std::string> seen;
  const auto progress = [&](std::size_t done, std::size_t total, const core::PairId& id) {
    seen.push_back(std::to_string(done) + "/" + std::to_string(total) + " " + id.text());
  };
  std::vector<std::string> remarks;
  EXPECT_EQ(writeDatasetBag(BrokenMiddle(), path_, {}, progress, &problems, &remarks), 2u);
  EXPECT_EQ(remarks, (std::vector<std::string>{"one pair is left out"}));
  EXPECT_EQ(seen, (std::vector<std::string>{"1/3 made_up/scene/1-2", "2/3 made_up/broken/x",
                                            "3/3 made_up/scene/1-3"}));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].id.sequence, "broken");
  EXPECT_EQ(problems[0].id.pair, "x");
  EXPECT_EQ(problems[0].text(), "made_up/broken/x: " + problems[0].error);
  EXPECT_NE(problems[0].error.find("img7.ppm is missing"), std::string::npos);
  EXPECT_EQ(openBag(path_)->size(), 2u);
}

TEST_F(DatasetBag, MissingFileIsNamed) {
  EXPECT_NE(openError().find(path_ + " does not exist"), std::string::npos);
}

TEST_F(DatasetBag, OtherFilesAreNotBags) {
  std::ofstream(path_) << "just some text";
  EXPECT_NE(openError().find("not a bag"), std::string::npos);
  std::ofstream(path_, std::ios::trunc).close();
  EXPECT_NE(openError().find("not a bag"), std::string::npos);
}

TEST_F(DatasetBag, TruncatedBagTellsTheCure) {
  write({homographyPair(), labelledPair()});
  const auto size = fs::file_size(path_);
  for (const double part : {0.99, 0.7, 0.3}) {
    fs::resize_file(path_, static_cast<std::uintmax_t>(part * static_cast<double>(size)));
    EXPECT_NE(openError().find("run: rosbag reindex " + path_), std::string::npos) << openError();
  }
  fs::resize_file(path_, 20);
  EXPECT_NE(openError().find("run: rosbag reindex " + path_), std::string::npos) << openError();
}

TEST_F(DatasetBag, UnindexedBagTellsTheCure) {
  {
    // What an interrupted recording leaves behind: the file as it is before the bag is closed.
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    bag.setChunkThreshold(1000);
    for (int i = 1; i < 10; ++i)
      writeImage(bag, bag_topics::kLeft, ros::Time(i), "mono8", noise(64, 48, CV_8UC1, 1));
    const std::string copy = path_ + ".copy";
    std::ofstream(copy, std::ios::binary) << std::ifstream(path_, std::ios::binary).rdbuf();
    bag.close();
    fs::rename(copy, path_);
  }
  EXPECT_NE(openError().find("run: rosbag reindex " + path_), std::string::npos) << openError();
}

TEST_F(DatasetBag, DamagedChunkCostsPairsNotTheRun) {
  write({homographyPair(), labelledPair()});
  {
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(9000);  // inside the chunk with the images
    file << std::string(64, '\xa5');
  }
  const auto source = openBag(path_);
  core::ImagePair pair;
  int calls = 0;
  bool more = true;
  while (more && calls < 20) {
    ++calls;
    try {
      more = source->next(pair);
    } catch (const core::DatasetError&) {  // as long as it goes on
    }
  }
  EXPECT_FALSE(more);
}

TEST_F(DatasetBag, WrongTopicsAreListed) {
  record([](rosbag::Bag& bag) {
    std_msgs::String text;
    bag.write("/chatter", ros::Time(1), text);
    writeImage(bag, "/cam0/image_raw", ros::Time(1), "mono8", noise(8, 8, CV_8UC1, 1));
  });
  const std::string error = openError();
  EXPECT_NE(error.find("/chatter (std_msgs/String)"), std::string::npos) << error;
  EXPECT_NE(error.find("/cam0/image_raw (sensor_msgs/Image)"), std::string::npos) << error;
  EXPECT_NE(error.find("/left/image"), std::string::npos) << error;
}

TEST_F(DatasetBag, EmptyBagHasNoTopics) {
  record([](rosbag::Bag&) {});
  EXPECT_NE(openError().find("none"), std::string::npos);
}

TEST_F(DatasetBag, WrongTypeIsNamed) {
  record([](rosbag::Bag& bag) {
    bag.write(bag_topics::kLeft, ros::Time(1), std_msgs::String());
    bag.write(bag_topics::kRight, ros::Time(1), std_msgs::String());
  });
  const auto source = openBag(path_);
  core::ImagePair pair;
  const std::string error = errorOf([&] { source->next(pair); });
  EXPECT_NE(error.find("std_msgs/String"), std::string::npos) << error;
  EXPECT_FALSE(source->next(pair));
}

TEST_F(DatasetBag, MixedEncodingsWithoutGroundTruth) {
  record([](rosbag::Bag& bag) {
    writeImage(bag, bag_topics::kLeft, ros::Time(1), "rgb8", cv::Mat(8, 9, CV_8UC3, cv::Scalar(1, 2, 3)));
    writeImage(bag, bag_topics::kRight, ros::Time(1), "mono16", cv::Mat(10, 11, CV_16UC1, cv::Scalar(65535)));
    writeImage(bag, bag_topics::kLeft, ros::Time(2), "mono8", noise(9, 8, CV_8UC1, 1));
    writeImage(bag, bag_topics::kRight, ros::Time(2), "bgra8",
               cv::Mat(10, 11, CV_8UC4, cv::Scalar(1, 2, 3, 4)));
  });
  const auto source = openBag(path_);
  EXPECT_EQ(source->size(), 2u);
  core::ImagePair pair;
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.left.at<cv::Vec3b>(0, 0), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(pair.right.at<std::uint8_t>(0, 0), 255);
  EXPECT_EQ(pair.truth.kind, core::TruthKind::kNone);
  EXPECT_EQ(pair.id.text(), "made_up/bag/1.000000000");
  ASSERT_TRUE(source->next(pair));
  EXPECT_EQ(pair.left.type(), CV_8UC1);
  EXPECT_EQ(pair.right.type(), CV_8UC3);
  EXPECT_FALSE(source->next(pair));
}

TEST_F(DatasetBag, BrokenPairIsNamedAndTheNextOneRead) {
  record([](rosbag::Bag& bag) {
    writeImage(bag, bag_topics::kLeft, ros::Time(1), "mono8", noise(8, 8, CV_8UC1, 1));
    writeImage(bag, bag_topics::kRight, ros::Time(1), "32FC1", cv::Mat(8, 8, CV_32FC1, cv::Scalar(0)));
    writeImage(bag, bag_topics::kLeft, ros::Time(2), "mono8", noise(8, 8, CV_8UC1, 2));  // no right image
    GroundTruth truth;
    truth.header.stamp = ros::Time(3);
    truth.dataset = "d";
    truth.sequence = "s";
    truth.pair = "p";
    truth.kind = 77;
    bag.write(bag_topics::kGroundTruth, ros::Time(3), truth);
    writeImage(bag, bag_topics::kLeft, ros::Time(3), "mono8", noise(8, 8, CV_8UC1, 3));
    writeImage(bag, bag_topics::kRight, ros::Time(3), "mono8", noise(8, 8, CV_8UC1, 3));
    writeImage(bag, bag_topics::kLeft, ros::Time(4), "mono8", noise(8, 8, CV_8UC1, 4));
    writeImage(bag, bag_topics::kRight, ros::Time(4), "mono8", noise(8, 8, CV_8UC1, 4));
    writeImage(bag, bag_topics::kRight, ros::Time(4), "mono8", noise(8, 8, CV_8UC1, 5));
    writeImage(bag, bag_topics::kLeft, ros::Time(5), "mono8", noise(8, 8, CV_8UC1, 5));
    writeImage(bag, bag_topics::kRight, ros::Time(5), "mono8", noise(8, 8, CV_8UC1, 5));
  });
  const auto source = openBag(path_);
  core::ImagePair pair;
  const auto expectError = [&](const std::string& pair_text, const std::string& what) {
    const std::string error = errorOf([&] { source->next(pair); });
    EXPECT_NE(error.find(pair_text), std::string::npos) << error;
    EXPECT_NE(error.find(what), std::string::npos) << error;
  };
  expectError("made_up/bag/1.000000000", "/right/image: image encoding '32FC1'");
  expectError("made_up/bag/2.000000000", "no message on /right/image");
  expectError("d/s/p", "/ground_truth: GroundTruth message: kind");
  expectError("made_up/bag/4.000000000", "/right/image has several messages");
  ASSERT_TRUE(source->next(pair));
  EXPECT_TRUE(equal(pair.left, noise(8, 8, CV_8UC1, 5)));
  EXPECT_FALSE(source->next(pair));
}

}  // namespace
}  // namespace corrsel
