#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/random.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/features.h"
#include "ros/live/message_matcher.h"
#include "test_paths.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr int kFeatures = 50;

/// Features with random descriptors, which belong to the same points whatever `first` is: feature i of the
/// message shows point first + i.
FeaturesConstPtr message(int first, double stamp, const std::string& name = "net", int side = 640) {
  core::Features features;
  features.image_size = {side, 480};
  features.descriptors.create(kFeatures, 8, CV_32F);
  for (int i = 0; i < kFeatures; ++i) {
    core::Random random(static_cast<std::uint64_t>(first + i));
    features.keypoints.emplace_back(static_cast<float>(first + i), static_cast<float>(2 * i), 4.0F, 0.0F);
    for (int k = 0; k < 8; ++k) features.descriptors.at<float>(i, k) = float(random.uniform(-1, 1));
  }
  FeatureInfo info;
  info.header.stamp.fromSec(stamp);
  info.header.frame_id = "camera";
  info.name = name;
  info.seconds = 0.5;
  return boost::make_shared<Features>(toMsg(features, info));
}

/// A package of its own beside corrsel; the library of plugin_matchers.cpp is where catkin puts it.
class MessageMatcherTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_matchers_" + std::to_string(getpid()));
    fs::create_directories(root_ / "test_matchers");
    setenv("ROS_HOME", (root_ / "ros_home").c_str(), 1);
    setenv("ROS_PACKAGE_PATH", (root_.string() + ":" + testing::sourceDir()).c_str(), 1);
    setenv("CMAKE_PREFIX_PATH", testing::develDir().c_str(), 1);
    std::ofstream(root_ / "test_matchers/package.xml")
        << "<package "
           "format=\"2\"><name>test_matchers</name><version>1.0.0</version><description>-</description>"
        << "<maintainer email=\"a@b.example\">a</maintainer><license>BSD</license><depend>corrsel</depend>"
        << "<export><corrsel plugin=\"${prefix}/plugins.xml\"/></export></package>";
    std::ofstream(root_ / "test_matchers/plugins.xml")
        << "<library path=\"lib/libplugin_matchers\"><class name=\"test_matchers/InOrder\" "
        << "type=\"corrsel::testing::InOrder\" base_class_type=\"corrsel::Matcher\"/></library>";
    configure();
  }
  void TearDown() override { fs::remove_all(root_); }

  MessageMatcher::Change configure(const std::string& matcher = "descriptors",
                                   const std::string& options = "") {
    config_.matcher = matcher;
    config_.options = options;
    return matcher_.configure(config_, ~0U);
  }

  boost::shared_ptr<Correspondences> match(const FeaturesConstPtr& left,
                                           const FeaturesConstPtr& right = nullptr) {
    return matcher_.match({left, right, core::Stopwatch()});
  }

  std::string refusal(const FeaturesConstPtr& left, const FeaturesConstPtr& right) {
    try {
      match(left, right);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  fs::path root_;
  MatcherConfig config_ = MatcherConfig::__getDefault__();
  MessageMatcher matcher_{1};
};

TEST_F(MessageMatcherTest, PairsAreMatchedByTheirDescriptors) {
  const auto answer = match(message(0, 7), message(10, 7.5));
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->left_x.size(), std::size_t{kFeatures});
  for (std::uint32_t i = 10; i < kFeatures; ++i) {
    EXPECT_EQ(answer->right_index[i], i - 10);
    EXPECT_EQ(answer->distance[i], 0);
  }
  EXPECT_EQ(answer->header.stamp, ros::Time(7));
  EXPECT_EQ(answer->right_stamp, ros::Time(7.5));
  EXPECT_EQ(answer->right_frame_id, "camera");
  EXPECT_EQ(answer->features, "net");
  EXPECT_EQ(answer->left_width, 640U);
  EXPECT_EQ(answer->n_right_features, std::uint32_t{kFeatures});
  EXPECT_EQ(answer->left_frame.size(), std::size_t{6 * kFeatures});
  EXPECT_EQ(answer->seconds.detect, 1) << "the sum of both images";
  EXPECT_TRUE(std::isnan(answer->seconds.describe));
  config_.match_mutual = true;
  EXPECT_EQ(configure().error, "");
  EXPECT_LT(match(message(0, 7), message(10, 7.5))->left_x.size(), std::size_t{kFeatures});
}

TEST_F(MessageMatcherTest, FramesOfASequenceAreMatchedWithTheEarlierOne) {
  EXPECT_FALSE(match(message(0, 1)));
  const auto answer = match(message(5, 2));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->header.stamp, ros::Time(2));
  EXPECT_EQ(answer->right_stamp, ros::Time(1));
  EXPECT_EQ(answer->right_index[0], 5U);
  EXPECT_FALSE(match(message(5, 3, "other net"))) << "features of another kind";
  EXPECT_TRUE(match(message(6, 4, "other net")));
  EXPECT_FALSE(match(message(6, 2, "other net"))) << "a bag that starts again";
  EXPECT_FALSE(match(message(6, 5, "other net", 320))) << "images of another size";
}

TEST_F(MessageMatcherTest, AnotherPackageMayMatch) {
  MessageMatcher::Change change = configure("test_matchers/InOrder", "probability=0.25");
  EXPECT_EQ(change.error, "");
  EXPECT_EQ(change.matcher, "test_matchers/InOrder");
  EXPECT_TRUE(change.new_matcher);
  const auto answer = match(message(0, 7), message(10, 7));
  ASSERT_EQ(answer->probability.size(), std::size_t{kFeatures});
  EXPECT_EQ(answer->probability[3], 0.25F);
  EXPECT_EQ(answer->right_index[3], 3U);
  EXPECT_TRUE(answer->distance.empty());
  EXPECT_EQ(configure("test_matchers/InOrder", "broken=true").error, "");
  EXPECT_EQ(refusal(message(0, 7), message(10, 7)),
            "the matcher returned matches whose column probability has 51 elements, left_x has 50");
}

TEST_F(MessageMatcherTest, WhatDoesNotWorkLeavesTheMatcherInForce) {
  ASSERT_EQ(configure("test_matchers/InOrder").error, "");
  const auto failure = [this](const std::string& matcher, const std::string& options) {
    const MessageMatcher::Change change = configure(matcher, options);
    EXPECT_FALSE(change.new_matcher);
    EXPECT_EQ(config_.matcher, "test_matchers/InOrder");
    return change.error;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  std::string text = failure("test_matchers/InOder", "");
  EXPECT_TRUE(has(text, "unknown matcher 'test_matchers/InOder'; did you mean 'test_matchers/InOrder'"))
      << text;
  text = failure("test_matchers/InOrder", "probability=2");
  EXPECT_TRUE(has(text, "probability = 2 is outside [0, 1]")) << text;
  text = failure("descriptors", "probability=0.5");
  EXPECT_TRUE(has(text, "set match_mutual")) << text;
  text = failure("descriptors", "probability");
  EXPECT_TRUE(has(text, "'test_matchers/InOrder' stays in force")) << text;
  EXPECT_EQ(match(message(0, 7), message(10, 7))->probability.size(), std::size_t{kFeatures});
}

TEST_F(MessageMatcherTest, FeaturesOfDifferentKindsAreRefused) {
  const std::string text = refusal(message(0, 7), message(0, 7, "other net"));
  EXPECT_NE(
      text.find("the left features are net (descriptor_type 4, descriptor_length 8), the right ones are "
                "other net"),
      std::string::npos)
      << text;
  const auto without = boost::make_shared<Features>(*message(0, 7));
  without->descriptors.clear();
  EXPECT_NE(refusal(without, without).find("50 keypoints, but 0 descriptors"), std::string::npos);
}

}  // namespace
}  // namespace corrsel
