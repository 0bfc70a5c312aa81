// Image sources between cameras that this test plays: which images pair, which do not, what is reported, and
// that everything recovers.

#include "ros/live/image_source.h"

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/sync_policies/exact_time.h>
#include <message_filters/synchronizer.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <atomic>
#include <boost/make_shared.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "corrsel/random.h"
#include "ros/live/parameters.h"
#include "wait_for.h"

namespace corrsel {
namespace {

using namespace std::chrono_literals;

sensor_msgs::ImagePtr imageAt(const ros::Time& stamp, int width = 4, int height = 3) {
  const auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->header.stamp = stamp;
  msg->header.frame_id = "camera_optical";
  msg->encoding = "mono8";
  msg->width = static_cast<std::uint32_t>(width);
  msg->height = static_cast<std::uint32_t>(height);
  msg->step = msg->width;
  msg->data.assign(msg->step * msg->height, 7);
  return msg;
}

ros::Time at(double seconds) { return ros::Time(seconds); }

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

double gap(const ImageSet& set) {
  return std::abs(set.left->header.stamp.toSec() - set.right->header.stamp.toSec());
}

/// A source in a namespace of its own, and the publishers of its cameras. Callbacks are called by this
/// thread, within waitFor().
class ImageSourceTest : public ::testing::Test {
 protected:
  ImageSourceTest()
      : name_(::testing::UnitTest::GetInstance()->current_test_info()->name()),
        nh_(name_),
        pnh_(nh_, "node"),
        left_(nh_.advertise<sensor_msgs::Image>("left/image", 100)),
        right_(nh_.advertise<sensor_msgs::Image>("right/image", 100)) {
    nh_.setCallbackQueue(&queue_);
    parameters_.subscriber_queue_size = 100;
  }

  void open() {
    source_ =
        openImageSource(nh_, pnh_, parameters_, [this](ImageSet set) { sets_.push_back(std::move(set)); });
  }

  void openPair() {
    open();
    connect();
  }

  void connect() {
    source_->subscribe();
    ASSERT_TRUE(
        waitFor([this] { return left_.getNumSubscribers() == 1 && right_.getNumSubscribers() == 1; }));
  }

  /// Calls callbacks until the condition holds. @return false when it did not in time
  bool waitFor(const std::function<bool()>& condition) { return testing::waitFor(queue_, condition); }

  void sendLeft(const ros::Time& stamp) { send(left_, imageAt(stamp), &ImageSource::Counts::left); }
  void sendRight(const ros::Time& stamp) { send(right_, imageAt(stamp), &ImageSource::Counts::right); }
  void sendPair(const ros::Time& stamp) {
    sendLeft(stamp);
    sendRight(stamp);
  }

  /// Returns once the source has taken the image.
  void send(const ros::Publisher& publisher, const sensor_msgs::ImageConstPtr& image,
            std::size_t ImageSource::Counts::*count) {
    const std::size_t before = source_->counts().*count;
    publisher.publish(image);
    ASSERT_TRUE(waitFor([&] { return source_->counts().*count == before + 1; }));
  }

  void expectRecovered(double from) {
    for (int i = 0; i < 10; ++i) sendPair(at(from + 0.1 * i));
    ASSERT_GE(sets_.size(), 5u);
    for (std::size_t i = sets_.size() - 5; i < sets_.size(); ++i) {
      EXPECT_EQ(sets_[i].left->header.stamp, sets_[i].right->header.stamp);
    }
    EXPECT_EQ(sets_.back().left->header.stamp, at(from + 0.9));
  }

  std::string name_;
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_, pnh_;
  FeatureMatcherParameters parameters_;
  ros::Publisher left_, right_;
  std::unique_ptr<ImageSource> source_;
  std::vector<ImageSet> sets_;
};

using Image = sensor_msgs::Image;
using ExactTime = message_filters::sync_policies::ExactTime<Image, Image>;
using ApproximateTime = message_filters::sync_policies::ApproximateTime<Image, Image>;

/// message_filters alone, to know what PairSynchronizer has to do more.
template <class Policy>
struct MessageFilters {
  MessageFilters() : synchronizer(Policy(5)) {
    const auto paired = [this](const sensor_msgs::ImageConstPtr& left,
                               const sensor_msgs::ImageConstPtr& right) {
      gaps.push_back(std::abs(left->header.stamp.toSec() - right->header.stamp.toSec()));
    };
    synchronizer.registerCallback(
        boost::bind<void>(paired, boost::placeholders::_1, boost::placeholders::_2));
  }

  void left(double stamp) { synchronizer.template add<0>(imageAt(at(stamp))); }
  void right(double stamp) { synchronizer.template add<1>(imageAt(at(stamp))); }

  std::vector<double> gaps;
  message_filters::Synchronizer<Policy> synchronizer;
};

// Left images wait while the right camera is dead; then the clock jumps back.
TEST(MessageFilters, ExactTimeStarvesAfterAJumpBack) {
  MessageFilters<ExactTime> filters;
  for (int i = 0; i < 5; ++i) filters.left(1000 + i);
  for (int i = 0; i < 100; ++i) {
    filters.left(10 + i);
    filters.right(10 + i);
  }
  EXPECT_TRUE(filters.gaps.empty());
}

TEST(MessageFilters, ApproximateTimeLosesPairsAfterAJumpBack) {
  MessageFilters<ApproximateTime> filters;
  for (int i = 0; i < 5; ++i) filters.left(1000 + i);
  for (int i = 0; i < 100; ++i) {
    filters.left(10 + i);
    filters.right(10 + i);
  }
  EXPECT_LE(filters.gaps.size(), 96u);
}

TEST(MessageFilters, ApproximateTimeThrowsWhenStampsAreFarApart) {
  MessageFilters<ApproximateTime> filters;
  filters.left(4.2e9);
  EXPECT_THROW(filters.right(10.0), std::runtime_error);
}

TEST(MessageFilters, ApproximateTimeIsOneFrameLate) {
  MessageFilters<ApproximateTime> filters;
  for (int i = 0; i < 50; ++i) {
    filters.left(10.0 + 0.1 * i);
    filters.right(10.004 + 0.1 * i);
    EXPECT_EQ(filters.gaps.size(), static_cast<std::size_t>(i));
  }
}

TEST_F(ImageSourceTest, EqualStampsPairWithoutACopy) {
  openPair();
  const sensor_msgs::ImageConstPtr left = imageAt(at(10)), right = imageAt(at(10), 9, 8);
  send(left_, left, &ImageSource::Counts::left);
  EXPECT_TRUE(sets_.empty());
  send(right_, right, &ImageSource::Counts::right);
  ASSERT_EQ(sets_.size(), 1u);
  EXPECT_EQ(sets_[0].left.get(), left.get());
  EXPECT_EQ(sets_[0].right.get(), right.get());
  EXPECT_FALSE(sets_[0].left_mask);
  EXPECT_FALSE(sets_[0].right_mask);
  EXPECT_LT(sets_[0].waiting.seconds(), 30.0);
  EXPECT_EQ(source_->topics(),
            (std::vector<std::string>{"/" + name_ + "/left/image", "/" + name_ + "/right/image"}));
  EXPECT_EQ(source_->counts().sets, 1u);
  EXPECT_EQ(source_->complaint(), "");
}

TEST_F(ImageSourceTest, SizesMayChangeAndDiffer) {
  openPair();
  for (int i = 1; i < 20; ++i) {
    send(left_, imageAt(at(i), i, 2 * i), &ImageSource::Counts::left);
    send(right_, imageAt(at(i), 40 - i, 1), &ImageSource::Counts::right);
  }
  EXPECT_EQ(sets_.size(), 19u);
}

TEST_F(ImageSourceTest, ExactPairsAfterAJumpBack) {
  openPair();
  for (int i = 0; i < 5; ++i) sendLeft(at(1000 + i));
  source_->complaint();
  for (int i = 0; i < 10; ++i) sendPair(at(10 + i));
  EXPECT_EQ(sets_.size(), 10u);
  const std::string text = source_->complaint();
  EXPECT_TRUE(holds(text, "time went backwards 1 times, by up to 994 s")) << text;
  EXPECT_TRUE(holds(text, source_->topics()[0])) << text;
  EXPECT_FALSE(holds(text, source_->topics()[1])) << text;
  EXPECT_EQ(source_->complaint(), "");
}

TEST_F(ImageSourceTest, ApproximatePairsAfterAJumpBack) {
  parameters_.approximate_sync = true;
  openPair();
  for (int i = 0; i < 5; ++i) sendLeft(at(1000 + i));
  for (int i = 0; i < 10; ++i) sendPair(at(10 + i));
  EXPECT_EQ(sets_.size(), 10u);
  for (const ImageSet& set : sets_) EXPECT_EQ(gap(set), 0.0);
}

// The images arrive in the order of a bag that is played in a loop: one camera jumps first.
TEST_F(ImageSourceTest, EveryLoopOfABagLosesNothing) {
  openPair();
  for (int loop = 0; loop < 5; ++loop) {
    for (int i = 0; i < 10; ++i) sendPair(at(10 + i));
    sendLeft(at(20));  // its partner is not in the bag
  }
  EXPECT_EQ(sets_.size(), 50u);
}

TEST_F(ImageSourceTest, OneWildStampDoesNoHarm) {
  for (const bool approximate : {false, true}) {
    parameters_.approximate_sync = approximate;
    sets_.clear();
    source_.reset();
    openPair();
    for (int i = 0; i < 5; ++i) sendPair(at(10 + i));
    sendLeft(ros::Time(4294967295u, 999999999u));
    sendRight(at(15));
    expectRecovered(16);
    sendRight(ros::Time(4294967295u, 999999999u));
    sendLeft(at(20));
    expectRecovered(21);
  }
}

TEST_F(ImageSourceTest, ZeroStampsPairAndAreComplainedAbout) {
  for (const bool approximate : {false, true}) {
    parameters_.approximate_sync = approximate;
    sets_.clear();
    source_.reset();
    openPair();
    for (int i = 0; i < 10; ++i) sendPair(ros::Time());
    EXPECT_EQ(sets_.size(), 10u);
    const std::string text = source_->complaint();
    EXPECT_TRUE(holds(text, source_->topics()[0] + ": 10 of 10 stamps are zero")) << text;
    EXPECT_TRUE(holds(text, source_->topics()[1] + ": 10 of 10 stamps are zero")) << text;
    EXPECT_FALSE(holds(text, "repeat")) << text;
    expectRecovered(10);
  }
}

TEST_F(ImageSourceTest, RepeatedStampsPairAndAreComplainedAbout) {
  for (const bool approximate : {false, true}) {
    parameters_.approximate_sync = approximate;
    sets_.clear();
    source_.reset();
    openPair();
    for (int i = 0; i < 10; ++i) sendPair(at(5));
    EXPECT_EQ(sets_.size(), 10u);
    const std::string text = source_->complaint();
    EXPECT_TRUE(holds(text, source_->topics()[0] + ": 9 of 10 stamps repeat")) << text;
    expectRecovered(10);
  }
}

TEST_F(ImageSourceTest, AnyStampsAreSurvived) {
  for (const bool approximate : {false, true}) {
    parameters_.approximate_sync = approximate;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      core::Random random(seed);
      sets_.clear();
      source_.reset();
      openPair();
      const auto anyStamp = [&random] {
        switch (random.index(5)) {
          case 0:
            return ros::Time();
          case 1:
            return ros::Time(random.index(std::numeric_limits<std::uint32_t>::max()), 0);
          default:
            return at(100 + 0.1 * random.index(10));
        }
      };
      for (int i = 0; i < 20; ++i) {
        std::size_t n_left = source_->counts().left, n_right = source_->counts().right;
        for (int k = 0; k < 20; ++k) {
          const bool is_left = random.index(2) == 0;
          (is_left ? left_ : right_).publish(imageAt(anyStamp()));
          ++(is_left ? n_left : n_right);
        }
        ASSERT_TRUE(
            waitFor([&] { return source_->counts().left == n_left && source_->counts().right == n_right; }));
      }
      source_->complaint();
      for (const ImageSet& set : sets_) ASSERT_TRUE(set.left && set.right);
      expectRecovered(1000);
    }
  }
}

TEST_F(ImageSourceTest, ACameraThatDiesIsNamedAndComesBack) {
  openPair();
  for (int i = 0; i < 5; ++i) sendPair(at(10 + i));
  EXPECT_EQ(source_->complaint(), "");
  right_.shutdown();
  for (int i = 0; i < 20; ++i) sendLeft(at(20 + i));
  const std::string text = source_->complaint();
  EXPECT_TRUE(holds(text, "20 left images (" + source_->topics()[0] + ")")) << text;
  EXPECT_TRUE(holds(text, "0 right images (" + source_->topics()[1] + ", nobody publishes it)")) << text;
  EXPECT_TRUE(holds(text, "only 0 pairs")) << text;
  right_ = nh_.advertise<sensor_msgs::Image>("right/image", 100);
  ASSERT_TRUE(waitFor([this] { return right_.getNumSubscribers() == 1; }));
  sets_.clear();
  for (int i = 0; i < 5; ++i) sendPair(at(50 + i));
  EXPECT_EQ(sets_.size(), 5u);
  EXPECT_EQ(source_->complaint(), "");
}

TEST_F(ImageSourceTest, SilenceIsSaidOnce) {
  openPair();
  std::string text;
  ASSERT_TRUE(waitFor([&] {
    text += source_->complaint();
    return holds(text, source_->topics()[0] + ": no image for ") &&
           holds(text, source_->topics()[1] + ": no image for ");
  })) << text;
  EXPECT_TRUE(holds(text, " s, 1 publisher")) << text;
  EXPECT_EQ(source_->complaint(), "");
}

TEST_F(ImageSourceTest, StampsThatDifferGiveTheGapAndTheCures) {
  openPair();
  for (std::uint32_t i = 0; i < 20; ++i) {
    sendLeft(ros::Time(1700000000 + i, 900000000));
    sendRight(ros::Time(1700000000 + i, 912300000));
  }
  EXPECT_TRUE(sets_.empty());
  const std::string text = source_->complaint();
  EXPECT_TRUE(holds(text, "20 left images (" + source_->topics()[0] + ")")) << text;
  EXPECT_TRUE(holds(text, "20 right images (" + source_->topics()[1] + ")")) << text;
  EXPECT_TRUE(holds(text, "it is 0.0123 s")) << text;
  EXPECT_TRUE(holds(text, "triggered together")) << text;
  EXPECT_TRUE(holds(text, "~approximate_sync with")) << text;
  EXPECT_TRUE(holds(text, "~queue_size")) << text;
}

TEST_F(ImageSourceTest, SlowCamerasAreCountedUntilThereIsSomethingToSay) {
  openPair();
  sendLeft(at(10));
  EXPECT_EQ(source_->complaint(), "");
  sendLeft(at(11));
  EXPECT_EQ(source_->complaint(), "");
  sendLeft(at(12));
  const std::string text = source_->complaint();
  EXPECT_TRUE(holds(text, "3 left images")) << text;
}

TEST_F(ImageSourceTest, MaxIntervalKeepsApart) {
  parameters_.approximate_sync = true;
  parameters_.approximate_sync_max_interval = 0.1;
  openPair();
  for (int i = 0; i < 20; ++i) {
    sendLeft(at(10 + i));
    sendRight(at(10.25 + i));
  }
  EXPECT_TRUE(sets_.empty());
  const std::string text = source_->complaint();
  EXPECT_TRUE(holds(text, "a larger ~approximate_sync_max_interval, now 0.1 s")) << text;
}

TEST_F(ImageSourceTest, ApproximatePairsAreNotHeldBack) {
  parameters_.approximate_sync = true;
  openPair();
  for (int i = 0; i < 50; ++i) {
    sendLeft(at(10.0 + 0.1 * i));
    sendRight(at(10.004 + 0.1 * i));
    if (i >= 3) {  // it takes some images to know the period
      ASSERT_EQ(sets_.back().right->header.stamp, at(10.004 + 0.1 * i));
      EXPECT_LT(gap(sets_.back()), 0.005);
    }
  }
  EXPECT_EQ(sets_.size(), 50u);
  EXPECT_EQ(source_->complaint(), "");
}

TEST_F(ImageSourceTest, ApproximatePairsAreTheNearestOnesInSpiteOfJitterAndLosses) {
  parameters_.approximate_sync = true;
  parameters_.approximate_sync_max_interval = 0.03;
  openPair();
  core::Random random(3);
  int n_both = 0;
  for (int i = 0; i < 300; ++i) {
    const bool left = random.index(5) != 0, right = random.index(5) != 0;
    if (left) sendLeft(at(10.0 + 0.1 * i + random.uniform(0, 0.01)));
    if (right) sendRight(at(10.012 + 0.1 * i + random.uniform(0, 0.01)));
    n_both += left && right ? 1 : 0;
  }
  EXPECT_GE(sets_.size(), static_cast<std::size_t>(n_both) - 1);
  for (const ImageSet& set : sets_) EXPECT_LT(gap(set), 0.03);
}

TEST_F(ImageSourceTest, NothingWaitsWhileUnsubscribed) {
  openPair();
  sendLeft(at(10));
  source_->unsubscribe();
  source_->unsubscribe();
  ASSERT_TRUE(waitFor([this] { return left_.getNumSubscribers() == 0; }));
  connect();
  source_->subscribe();
  sendRight(at(10));
  EXPECT_TRUE(sets_.empty());
  sendPair(at(11));
  EXPECT_EQ(sets_.size(), 1u);
}

TEST_F(ImageSourceTest, MayBeUnsubscribedFromTheCallback) {
  source_ = openImageSource(nh_, pnh_, parameters_, [this](ImageSet set) {
    source_->unsubscribe();
    sets_.push_back(std::move(set));
  });
  connect();
  sendPair(at(10));
  ASSERT_EQ(sets_.size(), 1u);
  ASSERT_TRUE(waitFor([this] { return left_.getNumSubscribers() == 0; }));
  connect();
  sendPair(at(11));
  EXPECT_EQ(sets_.size(), 2u);
}

TEST_F(ImageSourceTest, UnsubscribeWaitsForTheCallbackAndNoneFollows) {
  for (int round = 0; round < 5; ++round) {
    std::atomic<bool> entered{false}, go_on{false}, left_it{false};
    std::atomic<int> n_calls{0};
    source_ = openImageSource(nh_, pnh_, parameters_, [&](const ImageSet&) {
      ++n_calls;
      entered = true;
      while (!go_on) std::this_thread::sleep_for(1ms);
      left_it = true;
    });
    connect();
    ros::AsyncSpinner spinner(1, &queue_);
    spinner.start();
    for (int i = 0; i < 20; ++i) {
      left_.publish(imageAt(at(10 + i)));
      right_.publish(imageAt(at(10 + i)));
    }
    ASSERT_TRUE(testing::waitFor([&] { return entered.load(); }));
    std::thread release([&] {
      source_->complaint();
      source_->counts();
      go_on = true;
    });
    source_->unsubscribe();
    EXPECT_TRUE(left_it);
    const int n = n_calls;
    source_.reset();
    release.join();
    EXPECT_EQ(n_calls, n);
    spinner.stop();
  }
}

TEST_F(ImageSourceTest, CountsAndComplaintsFromOtherThreads) {
  openPair();
  std::atomic<bool> stop{false};
  std::thread reader([&] {
    while (!stop) {
      source_->complaint();
      EXPECT_LE(source_->counts().sets, 200u);
      EXPECT_EQ(source_->topics().size(), 2u);
    }
  });
  for (int i = 0; i < 100; ++i) {
    sendPair(at(10 + i % 7));
    if (i % 10 == 9) {
      source_->unsubscribe();
      connect();
    }
  }
  stop = true;
  reader.join();
}

// Faster than it is taken: whatever is lost on the way, the newest pair comes through.
TEST_F(ImageSourceTest, TwoHundredHertz) {
  parameters_.subscriber_queue_size = 5;
  openPair();
  constexpr int kPairs = 400;
  std::thread cameras([this] {
    auto next = std::chrono::steady_clock::now();
    for (int i = 1; i <= kPairs; ++i) {
      left_.publish(imageAt(at(0.005 * i), 640, 480));
      right_.publish(imageAt(at(0.005 * i), 640, 480));
      std::this_thread::sleep_until(next += 5ms);
    }
  });
  EXPECT_TRUE(
      waitFor([this] { return !sets_.empty() && sets_.back().left->header.stamp == at(0.005 * kPairs); }));
  cameras.join();
  EXPECT_LE(sets_.size(), static_cast<std::size_t>(kPairs));
}

TEST_F(ImageSourceTest, MasksStandForLaterImages) {
  parameters_.use_mask = true;
  const ros::Publisher left_mask = nh_.advertise<sensor_msgs::Image>("left/mask", 1);
  const ros::Publisher right_mask = nh_.advertise<sensor_msgs::Image>("right/mask", 1);
  openPair();
  ASSERT_TRUE(
      waitFor([&] { return left_mask.getNumSubscribers() == 1 && right_mask.getNumSubscribers() == 1; }));
  sendPair(at(10));
  EXPECT_FALSE(sets_.back().left_mask);
  double stamp = 10;
  const auto maskSeen = [&](const sensor_msgs::ImageConstPtr& mask,
                            sensor_msgs::ImageConstPtr ImageSet::*side) {
    return waitFor([&] {
      sendPair(at(++stamp));
      return sets_.back().*side == mask;
    });
  };
  const sensor_msgs::ImageConstPtr first = imageAt(at(1)), second = imageAt(at(2));
  left_mask.publish(first);
  EXPECT_TRUE(maskSeen(first, &ImageSet::left_mask));
  EXPECT_FALSE(sets_.back().right_mask);
  right_mask.publish(first);
  EXPECT_TRUE(maskSeen(first, &ImageSet::right_mask));
  left_mask.publish(second);
  EXPECT_TRUE(maskSeen(second, &ImageSet::left_mask));
  EXPECT_EQ(sets_.back().right_mask, first);
  left_mask.publish(imageAt(at(3), 0, 0));
  EXPECT_TRUE(maskSeen(nullptr, &ImageSet::left_mask));
}

TEST_F(ImageSourceTest, MasksAreNotSubscribedUnlessWanted) {
  const ros::Publisher mask = nh_.advertise<sensor_msgs::Image>("left/mask", 1);
  openPair();
  sendPair(at(10));
  EXPECT_EQ(mask.getNumSubscribers(), 0u);
}

class SequenceTest : public ImageSourceTest {
 protected:
  void openSequence() {
    parameters_.mode = FeatureMatcherParameters::Mode::kSequence;
    images_ = nh_.advertise<sensor_msgs::Image>("image", 100);
    open();
    source_->subscribe();
    ASSERT_TRUE(waitFor([this] { return images_.getNumSubscribers() == 1; }));
  }

  void sendImage(const ros::Time& stamp) { send(images_, imageAt(stamp), &ImageSource::Counts::left); }

  ros::Publisher images_;
};

TEST_F(SequenceTest, EveryImageIsASet) {
  parameters_.use_mask = true;
  const ros::Publisher masks = nh_.advertise<sensor_msgs::Image>("mask", 1, true);
  masks.publish(imageAt(at(1)));
  openSequence();
  double stamp = 10;
  ASSERT_TRUE(waitFor([&] {
    sendImage(at(++stamp));
    return sets_.back().left_mask != nullptr;
  }));
  EXPECT_EQ(sets_.back().left_mask->header.stamp, at(1));
  EXPECT_EQ(sets_.size(), source_->counts().left);
  EXPECT_EQ(source_->counts().sets, source_->counts().left);
  EXPECT_EQ(source_->counts().right, 0u);
  EXPECT_FALSE(sets_.back().right);
  EXPECT_FALSE(sets_.back().right_mask);
  EXPECT_EQ(source_->topics(), (std::vector<std::string>{"/" + name_ + "/image"}));
  EXPECT_EQ(source_->complaint(), "");
  EXPECT_EQ(left_.getNumSubscribers(), 0u);
}

TEST_F(SequenceTest, OddStampsArePassedOnAndComplainedAbout) {
  openSequence();
  for (const double stamp : {10.0, 10.0, 0.0, 11.0, 5.0, 6.0}) sendImage(at(stamp));
  EXPECT_EQ(sets_.size(), 6u);
  const std::string text = source_->complaint();
  EXPECT_TRUE(holds(text, "1 of 6 stamps are zero")) << text;
  EXPECT_TRUE(holds(text, "1 of 6 stamps repeat")) << text;
  EXPECT_TRUE(holds(text, "backwards 2 times")) << text;
}

TEST_F(ImageSourceTest, ParametersAreReadAndWrongOnesAreReportedAndWrittenBack) {
  pnh_.setParam("mode", "stereo");
  pnh_.setParam("approximate_sync", true);
  pnh_.setParam("queue_size", -3);
  pnh_.setParam("subscriber_queue_size", 7);
  const std::vector<std::string> problems = readParameters(pnh_, parameters_);
  ASSERT_EQ(problems.size(), 2u);
  for (const char* part : {"/node/mode", "'stereo'", "pair", "sequence"}) {
    EXPECT_TRUE(holds(problems[0], part)) << problems[0];
  }
  EXPECT_TRUE(holds(problems[1], "/node/queue_size = -3 is outside [1, 1000]")) << problems[1];
  EXPECT_EQ(parameters_.mode, FeatureMatcherParameters::Mode::kPair);
  EXPECT_TRUE(parameters_.approximate_sync);
  EXPECT_EQ(parameters_.queue_size, 1);
  EXPECT_EQ(parameters_.subscriber_queue_size, 7);
  EXPECT_EQ(pnh_.param<std::string>("mode", ""), "pair");
  EXPECT_EQ(pnh_.param("queue_size", 0), 1);
  openPair();
  sendPair(at(10));
  EXPECT_EQ(sets_.size(), 1u);
}

TEST_F(ImageSourceTest, UnknownTransportFallsBackToRaw) {
  parameters_.image_transport = "carrier_pigeon";
  openPair();
  sendPair(at(10));
  EXPECT_EQ(sets_.size(), 1u);
  EXPECT_EQ(source_->topics()[0], "/" + name_ + "/left/image");
  EXPECT_EQ(pnh_.param<std::string>("image_transport", ""), "raw");
}

TEST_F(ImageSourceTest, CompressedImagesAreDecoded) {
  parameters_.image_transport = "compressed";
  open();
  left_ = nh_.advertise<sensor_msgs::CompressedImage>("left/image/compressed", 100);
  right_ = nh_.advertise<sensor_msgs::CompressedImage>("right/image/compressed", 100);
  connect();
  EXPECT_EQ(source_->topics()[1], "/" + name_ + "/right/image/compressed");

  const auto compressed = [](double stamp, const std::string& format, int type) {
    const auto msg = boost::make_shared<sensor_msgs::CompressedImage>();
    msg->header.stamp = at(stamp);
    msg->header.frame_id = "camera_optical";
    msg->format = format;
    cv::imencode("." + format, cv::Mat(48, 64, type, cv::Scalar(40, 80, 120)), msg->data);
    return msg;
  };
  const auto damaged = compressed(1, "jpg", CV_8UC1);
  damaged->data.assign(500, 1);
  left_.publish(damaged);
  right_.publish(boost::make_shared<sensor_msgs::CompressedImage>());
  left_.publish(compressed(2, "jpg", CV_8UC3));
  right_.publish(compressed(2, "png", CV_8UC1));
  ASSERT_TRUE(waitFor([this] { return sets_.size() == 1; }));
  EXPECT_EQ(sets_[0].left->encoding, "bgr8");
  EXPECT_EQ(sets_[0].right->encoding, "mono8");
  EXPECT_EQ(sets_[0].left->header.stamp, at(2));
  EXPECT_EQ(sets_[0].left->header.frame_id, "camera_optical");
  EXPECT_EQ(sets_[0].right->width, 64u);
  EXPECT_EQ(sets_[0].right->height, 48u);
  EXPECT_EQ(sets_[0].right->data.at(0), 40);
  EXPECT_EQ(source_->counts().left, 1u);
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "image_source_test");
  const ros::NodeHandle alive;  // the node must not shut down between tests
  return RUN_ALL_TESTS();
}
