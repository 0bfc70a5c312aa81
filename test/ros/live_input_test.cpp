// Bad input: the nodelets stay alive, report it once, and recover with the input.

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "live_fixture.h"

namespace corrsel {
namespace {

using testing::imageMsg;
using testing::Inbox;
using testing::Live;
using testing::Log;
using testing::texture;
using testing::waitFor;
using namespace std::chrono_literals;

/// The largest coordinate of a match, to see which image it belongs to.
float largest(const std::vector<float>& values) {
  return values.empty() ? 0.0F : *std::max_element(values.begin(), values.end());
}

class LiveInput : public Live {
 protected:
  void SetUp() override { start(); }

  /// Checks that neither the pair of this stamp nor a part of it gives a result, and that a good pair after
  /// it does.
  void expectDropped(const std::string& what, const sensor_msgs::ImagePtr& left,
                     const sensor_msgs::ImagePtr& right) {
    SCOPED_TRACE(what);
    const double before = matcherFailures();
    send(left, right);
    EXPECT_TRUE(waitFor([&] { return matcherFailures() > before; })) << diagnostics_->text();
    EXPECT_TRUE(answers());
    EXPECT_FALSE(found_->has(left->header.stamp));
    EXPECT_FALSE(selections_->has(left->header.stamp));
  }

  sensor_msgs::ImagePtr goodImage(const ros::Time& stamp) const {
    return imageMsg(stamp, "camera", "mono8", good_);
  }
};

TEST_F(LiveInput, SizesMayChangeInMidStream) {
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(200, 300), cv::Size(64, 48), cv::Size(320, 240)}) {
    const cv::Mat image = texture(size.width, size.height, 2);
    const ros::Time stamp = nextStamp();
    send(stamp, image, image);
    const CorrespondencesConstPtr found = found_->wait(stamp);
    ASSERT_TRUE(found) << size;
    EXPECT_EQ(found->left_width, static_cast<std::uint32_t>(size.width));
    EXPECT_EQ(found->right_height, static_cast<std::uint32_t>(size.height));
    EXPECT_LT(largest(found->left_x), static_cast<float>(size.width));
    EXPECT_TRUE(selections_->wait(stamp));
  }
}

TEST_F(LiveInput, LeftAndRightMayDifferInSize) {
  const ros::Time stamp = nextStamp();
  send(stamp, texture(640, 480, 2), texture(200, 300, 2));
  const CorrespondencesConstPtr found = found_->wait(stamp);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->left_width, 640u);
  EXPECT_EQ(found->right_width, 200u);
  EXPECT_EQ(found->right_height, 300u);
  EXPECT_TRUE(selections_->wait(stamp));
}

TEST_F(LiveInput, UnusableImagesAreDroppedWithTheReason) {
  const std::vector<std::pair<std::string, std::function<void(sensor_msgs::Image&)>>> cases = {
      {"unknown encoding", [](sensor_msgs::Image& image) { image.encoding = "no_such_encoding"; }},
      {"empty encoding", [](sensor_msgs::Image& image) { image.encoding.clear(); }},
      {"floats", [](sensor_msgs::Image& image) { image.encoding = "32FC1"; }},
      {"empty data", [](sensor_msgs::Image& image) { image.data.clear(); }},
      {"data cut off", [](sensor_msgs::Image& image) { image.data.resize(image.data.size() / 2); }},
      {"step too short", [](sensor_msgs::Image& image) { image.step = image.width / 2; }},
      {"step beyond the data", [](sensor_msgs::Image& image) { image.step = image.width * 3; }},
      {"no rows", [](sensor_msgs::Image& image) { image.height = 0; }},
      {"no columns", [](sensor_msgs::Image& image) { image.width = 0; }},
      {"huge", [](sensor_msgs::Image& image) { image.width = image.height = image.step = 0xFFFFFFFF; }},
      {"sizes that overflow",
       [](sensor_msgs::Image& image) {
         image.width = image.step = 0x10000;
         image.height = 0x10000;
       }},
  };
  for (const auto& [what, spoil] : cases) {
    const ros::Time stamp = nextStamp();
    const sensor_msgs::ImagePtr bad = goodImage(stamp);
    spoil(*bad);
    expectDropped(what, bad, goodImage(stamp));
  }
  const ros::Time stamp = nextStamp();
  const sensor_msgs::ImagePtr bad = goodImage(stamp);
  bad->encoding = "no_such_encoding";
  expectDropped("the right one", goodImage(stamp), bad);
  EXPECT_NE(diagnostics_->of(matcher(), "processing").values["last failure"].find("no_such_encoding"),
            std::string::npos)
      << diagnostics_->text();
}

TEST_F(LiveInput, BadImagesAreSaidOnceInAWhile) {
  Log log;
  // A second of them at 100 Hz; the throttle may still be silent because of a test before this one.
  ASSERT_TRUE(waitFor([&] {
    const ros::Time stamp = nextStamp();
    const sensor_msgs::ImagePtr bad = goodImage(stamp);
    bad->encoding = "another_encoding";
    send(bad, goodImage(stamp));
    return log.count("another_encoding") >= 1;
  }));
  for (int i = 0; i < 100; ++i) {
    const ros::Time stamp = nextStamp();
    const sensor_msgs::ImagePtr bad = goodImage(stamp);
    bad->encoding = "another_encoding";
    send(bad, goodImage(stamp));
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_LE(log.count("another_encoding"), 3u) << log.text();
  EXPECT_TRUE(answers());
}

TEST_F(LiveInput, StampsMayJump) {
  for (const double seconds : {50.0, 49.0, 1e9, 49.5, 10.0, 4e9, 3.0}) {
    SCOPED_TRACE(seconds);
    std::vector<ros::Time> sent;
    // The first pair after a jump may be lost, the next ones not.
    EXPECT_TRUE(waitFor([&] {
      sent.push_back(ros::Time(seconds) + ros::Duration(0.001 * static_cast<double>(sent.size())));
      send(sent.back(), good_, good_);
      return waitFor([&] { return answered(sent.back()); }, 200ms);
    }));
    EXPECT_LE(sent.size(), testing::kSanitized ? 20u : 4u);
  }
}

TEST_F(LiveInput, ZeroStampsAreSaidAndSurvived) {
  for (int i = 0; i < 20; ++i) {
    send(ros::Time(), good_, good_);
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_TRUE(answers());
}

TEST_F(LiveInput, EqualStampsAreSurvived) {
  const ros::Time stamp = nextStamp();
  for (int i = 0; i < 30; ++i) {
    send(stamp, good_, good_);
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_TRUE(selections_->wait(stamp));
  EXPECT_TRUE(answers());
}

TEST_F(LiveInput, ACameraDiesAndComesBack) {
  right_.shutdown();
  ASSERT_TRUE(waitFor([&] {
    left_.publish(goodImage(nextStamp()));
    std::this_thread::sleep_for(20ms);
    const auto status = diagnostics_->of(matcher(), "input");
    return status.level > 0 && status.message.find("right") != std::string::npos;
  })) << diagnostics_->text();
  right_ = nh_.advertise<sensor_msgs::Image>("right/image", 10);
  EXPECT_TRUE(answers());
  // And the diagnostics are content again.
  EXPECT_TRUE(waitFor([&] {
    const ros::Time stamp = nextStamp();
    send(stamp, good_, good_);
    std::this_thread::sleep_for(20ms);
    return diagnostics_->of(matcher(), "input").level == 0;
  })) << diagnostics_->text();
}

TEST_F(LiveInput, PairsThatDoNotFormAreExplained) {
  Log log;
  // Ten seconds apart in their stamps, whatever ~queue_size is.
  EXPECT_TRUE(waitFor(
      [&] {
        const ros::Time stamp = nextStamp();
        send(goodImage(stamp), goodImage(stamp + ros::Duration(10.05)));
        std::this_thread::sleep_for(30ms);
        return log.count(ns_ + "/left/image") > 0;
      },
      testing::kSanitized ? 120s : 40s))
      << log.text();
  const std::string text = log.text();
  for (const std::string& part : {ns_ + "/right/image", std::string("pairs"), std::string("approximate_sync"),
                                  std::string("queue_size")}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
  EXPECT_TRUE(answers());
}

TEST_F(LiveInput, BlackAndSaturatedFramesAreAnswered) {
  for (const int grey : {0, 255}) {
    const cv::Mat blank(240, 320, CV_8UC1, cv::Scalar(grey));
    const SelectionConstPtr selection = ask(blank, blank);
    ASSERT_TRUE(selection) << grey;
    EXPECT_EQ(selection->n_input, 0u);
    EXPECT_EQ(selection->n_selected, 0u);
  }
  EXPECT_TRUE(waitFor([&] {
    const std::string failure = diagnostics_->of(selector(), "processing").values["last failure"];
    return failure.find("no putative matches: the left image is overexposed: 100 % of the pixels") !=
           std::string::npos;
  })) << diagnostics_->text();
  EXPECT_TRUE(waitFor([&] {
    auto status = diagnostics_->of(matcher(), "processing");
    return status.level == 1 && status.values["right image"].find("saturated 100 %") != std::string::npos &&
           status.message.find("the right image is overexposed") != std::string::npos;
  })) << diagnostics_->text();
  const SelectionConstPtr selection = ask(good_, good_);
  ASSERT_TRUE(selection);
  EXPECT_GT(selection->n_selected, 50u);
}

TEST_F(LiveInput, SlowAndFastCameras) {
  for (const auto& [period, n] : {std::pair{100ms, 5}, std::pair{5ms, 300}}) {
    SCOPED_TRACE(n);
    auto next = std::chrono::steady_clock::now();
    std::vector<ros::Time> sent;
    for (int i = 0; i < n; ++i) {
      sent.push_back(nextStamp());
      send(sent.back(), good_, good_);
      next += period;
      std::this_thread::sleep_until(next);
    }
    // Newest first: the last pair has a result, and results never go back in time.
    EXPECT_TRUE(waitFor([&] { return answered(sent.back()); }));
  }
  ros::Time before;
  for (const auto& item : matches_->all()) {
    EXPECT_LT(before, item.message->header.stamp);
    before = item.message->header.stamp;
  }
}

class LiveSettings : public Live {};

TEST_F(LiveSettings, NonsenseAtStartIsRepairedAndSaid) {
  Log log;
  setDefaults();
  set(selector() + "/selector", std::string("no_such_selector"));
  set(selector() + "/gms_alpha", -5.0);
  set(matcher() + "/features", std::string("surf+surf"));
  set(matcher() + "/orb_levels", 99);
  set(matcher() + "/pending", -3);
  set(matcher() + "/subscriber_queue_size", -3);
  openCameras();
  openInboxes();
  loadMatcher();
  loadSelector();
  EXPECT_TRUE(answers());
  for (const std::string part : {"no_such_selector", "gms_alpha", "surf+surf", "orb_levels"}) {
    EXPECT_GE(log.count(part), 1u) << part << "\n" << log.text();
  }
}

TEST_F(LiveSettings, UnknownModeIsSaidAndPairsAreTaken) {
  Log log;
  set(matcher() + "/mode", std::string("triple"));
  start();
  EXPECT_GE(log.count("triple"), 1u) << log.text();
  EXPECT_GE(log.count("sequence"), 1u) << log.text();
}

TEST_F(LiveSettings, MasksHideFeatures) {
  set(matcher() + "/use_mask", true);
  ros::Publisher left_mask = nh_.advertise<sensor_msgs::Image>("left/mask", 1, true);
  start();
  cv::Mat mask(240, 320, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 160, 240)).setTo(0);
  left_mask.publish(imageMsg(nextStamp(), "camera", "mono8", mask));
  EXPECT_TRUE(waitFor([&] {
    const ros::Time stamp = nextStamp();
    send(stamp, good_, good_);
    const CorrespondencesConstPtr found = found_->wait(stamp);
    return found && !found->left_x.empty() &&
           *std::min_element(found->left_x.begin(), found->left_x.end()) >= 159.0F &&
           *std::min_element(found->right_x.begin(), found->right_x.end()) < 159.0F;
  }));
  // A mask of another size cannot be used. This is reported, and pairs are not processed as if there were no
  // mask.
  const double before = matcherFailures();
  left_mask.publish(imageMsg(nextStamp(), "camera", "mono8", cv::Mat(100, 100, CV_8UC1, cv::Scalar(255))));
  EXPECT_TRUE(waitFor([&] {
    send(nextStamp(), good_, good_);
    std::this_thread::sleep_for(20ms);
    return matcherFailures() > before;
  })) << diagnostics_->text();
  left_mask.publish(imageMsg(nextStamp(), "camera", "mono8", mask));
  EXPECT_TRUE(answers());
}

TEST_F(LiveSettings, RegionsOfInterestAreKept) {
  start();
  testing::configure(matcher(), {}, {},
                     {{"roi_x", 100}, {"roi_y", 50}, {"roi_width", 150}, {"roi_height", 120}});
  const ros::Time stamp = nextStamp();
  send(stamp, good_, good_);
  const CorrespondencesConstPtr found = found_->wait(stamp);
  ASSERT_TRUE(found);
  ASSERT_FALSE(found->left_x.empty());
  EXPECT_EQ(found->left_width, 320u);
  for (std::size_t i = 0; i < found->left_x.size(); ++i) {
    EXPECT_TRUE(cv::Rect2f(99, 49, 152, 122).contains({found->left_x[i], found->left_y[i]}));
    EXPECT_TRUE(cv::Rect2f(99, 49, 152, 122).contains({found->right_x[i], found->right_y[i]}));
  }
  // A region outside of the image is reported, and the next change corrects it.
  testing::configure(matcher(), {}, {}, {{"roi_x", 5000}, {"roi_y", 5000}});
  send(nextStamp(), good_, good_);
  EXPECT_TRUE(waitFor([&] { return matcherFailures() > 0; })) << diagnostics_->text();
  testing::configure(matcher(), {}, {}, {{"roi_x", 0}, {"roi_y", 0}, {"roi_width", 0}, {"roi_height", 0}});
  EXPECT_TRUE(answers());
}

TEST_F(LiveSettings, SequenceComparesWithTheFrameBefore) {
  setDefaults();
  set(matcher() + "/mode", std::string("sequence"));
  ros::Publisher camera = nh_.advertise<sensor_msgs::Image>("image", 10);
  openInboxes();
  loadMatcher();
  loadSelector();
  ASSERT_TRUE(waitFor([&] { return camera.getNumSubscribers() >= 1; }));
  // Frames until two in a row were taken; from then on every one that the test waits for has a result.
  ros::Time before, stamp;
  ASSERT_TRUE(waitFor([&] {
    before = stamp;
    stamp = nextStamp();
    camera.publish(imageMsg(stamp, "camera", "mono8", good_));
    return waitFor([&] { return selections_->has(stamp); }, 500ms);
  }));
  const auto next = [&](const cv::Mat& image) {
    before = stamp;
    stamp = nextStamp();
    camera.publish(imageMsg(stamp, "camera", "mono8", image));
    return found_->wait(stamp);
  };
  CorrespondencesConstPtr found = next(good_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->right_stamp, before);
  EXPECT_EQ(found->right_frame_id, "camera");
  EXPECT_GT(found->left_x.size(), 50u);
  // Two frames back, as soon as there are two.
  testing::configure(matcher(), {}, {}, {{"sequence_step", 2}});
  std::vector<ros::Time> sent = {stamp};
  EXPECT_TRUE(waitFor([&] {
    sent.push_back(stamp = nextStamp());
    camera.publish(imageMsg(stamp, "camera", "mono8", good_));
    return waitFor([&] { return selections_->has(stamp); }, 500ms) && sent.size() >= 4;
  }));
  EXPECT_EQ(found_->wait(stamp)->right_stamp, sent[sent.size() - 3]);
  // Another size begins a new sequence; it has results from its second frame on.
  EXPECT_TRUE(waitFor([&] {
    stamp = nextStamp();
    camera.publish(imageMsg(stamp, "camera", "mono8", texture(400, 300, 3)));
    return waitFor([&] { return selections_->has(stamp); }, 500ms);
  }));
  EXPECT_EQ(found_->wait(stamp)->right_width, 400u);
  // Time that goes back does, too.
  EXPECT_TRUE(waitFor([&] {
    stamp = ros::Time(5.0) + (nextStamp() - ros::Time(1000));
    camera.publish(imageMsg(stamp, "camera", "mono8", good_));
    return waitFor([&] { return selections_->has(stamp); }, 500ms);
  }));
  EXPECT_LE(found_->wait(stamp)->right_stamp, stamp);
}

TEST_F(LiveSettings, SequencesByOpticalFlow) {
  setDefaults();
  set(matcher() + "/mode", std::string("sequence"));
  set(matcher() + "/tracker", std::string("flow"));
  ros::Publisher camera = nh_.advertise<sensor_msgs::Image>("image", 10);
  openInboxes();
  loadMatcher();
  loadSelector();
  ASSERT_TRUE(waitFor([&] { return camera.getNumSubscribers() >= 1; }));
  const auto answer = [&] {
    ros::Time stamp;
    EXPECT_TRUE(waitFor([&] {
      stamp = nextStamp();
      camera.publish(imageMsg(stamp, "camera", "mono8", good_));
      return waitFor([&] { return selections_->has(stamp); }, 500ms);
    }));
    return found_->wait(stamp);
  };
  CorrespondencesConstPtr found = answer();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->features, "orb+flow");
  ASSERT_GT(found->left_x.size(), 50u);
  for (std::size_t i = 0; i < found->left_x.size(); ++i) {
    EXPECT_NEAR(found->left_x[i], found->right_x[i], 0.05);
    EXPECT_NEAR(found->left_y[i], found->right_y[i], 0.05);
  }
  testing::configure(matcher(), {}, {}, {{"flow_max_points", 30}});
  found = answer();
  ASSERT_TRUE(found);
  EXPECT_LE(found->left_x.size(), 30u);
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_->of(matcher(), "processing").values["features"] == "orb+flow";
  })) << diagnostics_->text();
}

}  // namespace
}  // namespace corrsel
