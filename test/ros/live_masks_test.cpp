#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "live_fixture.h"
#include "ros/live/callback_thread.h"
#include "ros/live/masked_source.h"

// Masks: latched ones and those of files hide features, and stamped ones reject matches.
namespace corrsel::testing {
namespace {

class LiveMasks : public Live {
 protected:
  /// Loads FeatureMatcher and Selector with stamped masks of both cameras.
  void startStamped(double timeout) {
    set(matcher() + "/use_mask", true);
    set(matcher() + "/mask_mode", std::string("stamped"));
    set(selector() + "/use_mask", true);
    set(selector() + "/mask_mode", std::string("stamped"));
    set(selector() + "/mask_timeout", timeout);
    setDefaults();
    set(selector() + "/selector", std::string("keep_all"));
    openCameras();
    left_mask_ = nh_.advertise<sensor_msgs::Image>("left/mask", 10);
    right_mask_ = nh_.advertise<sensor_msgs::Image>("right/mask", 10);
    openInboxes();
    loadMatcher();
    loadSelector();
    ASSERT_TRUE(waitFor([this] {
      return left_.getNumSubscribers() == 1 && right_.getNumSubscribers() == 1 && found_->connected() &&
             selections_->connected() && matches_->connected() && left_mask_.getNumSubscribers() >= 1 &&
             right_mask_.getNumSubscribers() >= 1;
    }));
    EXPECT_EQ(left_mask_.getNumSubscribers(), 1u) << "FeatureMatcher does not subscribe to stamped masks";
  }

  /// Sends a pair and waits for its matches.
  ros::Time sendPair() {
    const ros::Time stamp = nextStamp();
    send(stamp, good_, good_);
    EXPECT_TRUE(found_->wait(stamp));
    return stamp;
  }

  /// Excludes the left part of the image, `columns` wide.
  static sensor_msgs::ImagePtr mask(const ros::Time& stamp, int columns) {
    cv::Mat pixels(240, 320, CV_8UC1, cv::Scalar(255));
    pixels.colRange(0, columns).setTo(0);
    return imageMsg(stamp, "camera", "mono8", pixels);
  }

  /// The messages about a pair, which must have come.
  struct Outcome {
    CorrespondencesConstPtr found, matches;
    SelectionConstPtr selection;
  };
  Outcome outcome(const ros::Time& stamp) {
    return {found_->wait(stamp), matches_->wait(stamp), selections_->wait(stamp)};
  }

  /// Whether exactly the matches with a point in the first columns of its image were rejected, and all
  /// fields agree with this. The selector keeps all that it is given.
  static ::testing::AssertionResult isMasked(const Outcome& outcome, int left_columns, int right_columns) {
    if (!outcome.found || !outcome.matches || !outcome.selection) {
      return ::testing::AssertionFailure() << "a message is missing";
    }
    const Correspondences& found = *outcome.found;
    const Selection& selection = *outcome.selection;
    if (selection.mask.size() != found.left_x.size() || selection.n_input != found.left_x.size()) {
      return ::testing::AssertionFailure()
             << "rows do not fit: " << selection.mask.size() << " of " << found.left_x.size();
    }
    std::size_t n_masked = 0;
    for (std::size_t i = 0; i < found.left_x.size(); ++i) {
      const bool masked = found.left_x[i] < static_cast<float>(left_columns) - 0.5F ||
                          found.right_x[i] < static_cast<float>(right_columns) - 0.5F;
      n_masked += masked ? 1 : 0;
      if (masked == (selection.mask[i] != 0)) {
        return ::testing::AssertionFailure() << "row " << i << " at " << found.left_x[i] << ", "
                                             << found.right_x[i] << " has " << int{selection.mask[i]};
      }
    }
    if (selection.n_masked != n_masked || outcome.matches->left_x.size() != found.left_x.size() - n_masked) {
      return ::testing::AssertionFailure()
             << "counts do not fit: " << selection.n_masked << " of " << n_masked;
    }
    return n_masked > 0 && n_masked < found.left_x.size()
               ? ::testing::AssertionSuccess()
               : ::testing::AssertionFailure() << n_masked << " of " << found.left_x.size() << " were masked";
  }

  double maskCount(const std::string& key) { return diagnostics_->of(selector(), "processing").number(key); }

  ros::Publisher left_mask_, right_mask_;
};

TEST_F(LiveMasks, ALateMaskFiltersThePairWithItsStamp) {
  startStamped(10.0);
  const ros::Time first = sendPair(), second = sendPair();
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(selections_->has(first)) << "it waits for its masks";
  left_mask_.publish(mask(second, 200));
  right_mask_.publish(mask(second, 0));
  const Outcome later = outcome(second);
  EXPECT_TRUE(isMasked(later, 200, 0));
  EXPECT_EQ(later.selection->mask_use, Selection::MASK_APPLIED);
  const Outcome earlier = outcome(first);  // the masks of the second pair show that it gets none
  ASSERT_TRUE(earlier.selection);
  EXPECT_EQ(earlier.selection->mask_use, Selection::MASK_MISSING);
  EXPECT_EQ(earlier.selection->n_masked, 0u);
  EXPECT_EQ(earlier.selection->n_selected, earlier.found->left_x.size());

  const ros::Time third = sendPair();
  left_mask_.publish(mask(third, 100));
  std::this_thread::sleep_for(20ms);
  EXPECT_FALSE(selections_->has(third)) << "the mask of one camera is not enough";
  right_mask_.publish(mask(third, 180));
  const Outcome both = outcome(third);
  EXPECT_TRUE(isMasked(both, 100, 180));
  EXPECT_EQ(both.selection->mask_use, Selection::MASK_APPLIED);

  const std::vector<Inbox<Selection>::Item> all = selections_->all();
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.message->header.stamp < b.message->header.stamp;
  })) << "pairs are not reordered";
  EXPECT_TRUE(waitFor([&] {
    return maskCount("masks") == 4 && maskCount("pairs with their masks") == 2 &&
           maskCount("pairs without a mask") >= 1;
  })) << diagnostics_->text();
}

TEST_F(LiveMasks, APairGoesOnAfterTheTimeoutWithAMark) {
  startStamped(0.3);
  const ros::Time stamp = nextStamp();
  left_mask_.publish(mask(stamp, 200));  // the right one never comes
  const ros::WallTime sent = ros::WallTime::now();
  send(stamp, good_, good_);
  const Outcome result = outcome(stamp);
  EXPECT_GE((ros::WallTime::now() - sent).toSec(), 0.3);
  EXPECT_TRUE(isMasked(result, 200, 0)) << "the mask that is there is used";
  EXPECT_EQ(result.selection->mask_use, Selection::MASK_MISSING);
  EXPECT_TRUE(waitFor([&] { return maskCount("pairs without a mask") >= 1; })) << diagnostics_->text();
  right_mask_.publish(mask(stamp, 200));  // too late
  const ros::Time next = sendPair();
  ASSERT_TRUE(selections_->wait(next));
  EXPECT_TRUE(waitFor([&] { return maskCount("masks that found no pair") >= 1; })) << diagnostics_->text();
}

TEST_F(LiveMasks, ATopicThatNobodyPublishesIsNotWaitedFor) {
  startStamped(10.0);
  right_mask_.shutdown();
  const ros::Time stamp = sendPair();
  left_mask_.publish(mask(stamp, 150));
  const Outcome result = outcome(stamp);
  EXPECT_TRUE(isMasked(result, 150, 0));
  EXPECT_EQ(result.selection->mask_use, Selection::MASK_APPLIED);
}

TEST_F(LiveMasks, LabelImagesExcludeClassesWidenedByTheDilation) {
  set(selector() + "/mask_classes", std::string("11, 13"));
  set(selector() + "/mask_dilation", 4);
  startStamped(10.0);
  Log log;
  cv::Mat labels(120, 160, CV_16UC1, cv::Scalar(0));  // half of the size of the images
  labels.colRange(0, 30).setTo(11);
  labels.colRange(30, 66).setTo(13);
  labels.colRange(66, 160).setTo(12);
  const ros::Time stamp = sendPair();
  left_mask_.publish(imageMsg(stamp, "camera", "mono16", labels));
  right_mask_.publish(imageMsg(stamp, "camera", "16UC1", cv::Mat::zeros(120, 160, CV_16UC1)));
  const Outcome result = outcome(stamp);
  EXPECT_TRUE(isMasked(result, 140, 0));
  EXPECT_EQ(result.selection->mask_use, Selection::MASK_APPLIED);

  // What cannot be used is reported, and the pair goes on.
  const ros::Time odd = sendPair();
  left_mask_.publish(imageMsg(odd, "camera", "mono8", cv::Mat::zeros(100, 300, CV_8UC1)));
  right_mask_.publish(imageMsg(odd, "camera", "mono8", cv::Mat::zeros(240, 320, CV_8UC1)));
  const Outcome refused = outcome(odd);
  ASSERT_TRUE(refused.selection);
  EXPECT_EQ(refused.selection->mask_use, Selection::MASK_MISSING);
  EXPECT_EQ(refused.selection->n_masked, 0u);
  EXPECT_TRUE(waitFor([&] { return log.count("left mask has 300x100 px; needed: 320x240 px") > 0; }))
      << log.text();
}

TEST_F(LiveMasks, InASequenceTheMaskOfTheEarlierFrameCountsForTheRightSide) {
  for (const std::string& nodelet : {matcher(), selector()}) {
    set(nodelet + "/mode", std::string("sequence"));
    set(nodelet + "/use_mask", true);
    set(nodelet + "/mask_mode", std::string("stamped"));
  }
  setDefaults();
  set(selector() + "/selector", std::string("keep_all"));
  set(selector() + "/mask_timeout", 10.0);
  set(matcher() + "/pending", 10);
  ros::Publisher images = nh_.advertise<sensor_msgs::Image>("image", 10);
  ros::Publisher masks = nh_.advertise<sensor_msgs::Image>("mask", 10);
  openInboxes();
  loadMatcher();
  loadSelector();
  ASSERT_TRUE(waitFor([&] {
    return images.getNumSubscribers() == 1 && masks.getNumSubscribers() == 1 && found_->connected() &&
           selections_->connected() && matches_->connected();
  }));
  const auto frame = [&](int columns) {
    const ros::Time stamp = nextStamp();
    images.publish(imageMsg(stamp, "camera", "mono8", good_));
    masks.publish(mask(stamp, columns));
    return stamp;
  };
  frame(120);  // the first frame has no pair
  const Outcome first = outcome(frame(0));
  EXPECT_TRUE(isMasked(first, 0, 120));
  EXPECT_EQ(first.selection->mask_use, Selection::MASK_APPLIED);
  frame(90);
  EXPECT_TRUE(isMasked(outcome(frame(150)), 150, 90));
}

TEST_F(LiveMasks, MasksThatBelongToNoPairAreComplainedAbout) {
  correspondences_ = nh_.advertise<Correspondences>("correspondences", 10);
  left_mask_ = nh_.advertise<sensor_msgs::Image>("left/mask", 10);
  CallbackThread thread;
  SelectorParameters parameters;
  parameters.mask_timeout = 0.01;
  std::mutex mutex;
  std::vector<ros::Time> order;
  std::vector<std::string> problems;
  const auto receive = [&](const TimedMatches& matches, const PairMasks& masks) {
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_TRUE(masks.missing && masks.left.empty());
    order.push_back(matches.message->header.stamp);
  };
  MaskedSource source(thread.handle(nh_), parameters, receive,
                      [&problems](const std::string& problem) { problems.push_back(problem); });
  source.subscribe();
  ASSERT_TRUE(waitFor(
      [&] { return correspondences_.getNumSubscribers() == 1 && left_mask_.getNumSubscribers() == 1; }));
  EXPECT_EQ(source.complaint(), "");
  std::vector<ros::Time> sent;
  for (int i = 0; i < 3; ++i) {
    Correspondences pair;
    pair.header.stamp = pair.right_stamp = nextStamp();
    sent.push_back(pair.header.stamp);
    correspondences_.publish(pair);
    left_mask_.publish(mask(pair.header.stamp + ros::Duration(0.01), 50));
  }
  left_mask_.publish(imageMsg(sent[2], "camera", "32FC1", cv::Mat::zeros(240, 320, CV_32FC1)));
  ASSERT_TRUE(waitFor([&] { return source.counts().masks == 3 && source.counts().pairs_unmasked == 3; }));
  const std::string text = source.complaint();
  for (const std::string& part : {"3 masks (" + ns_ + "/left/mask, " + ns_ + "/right/mask) and 3 pairs",
                                  std::string("~mask_max_age")}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  EXPECT_EQ(source.complaint(), "") << "nothing has come since";
  EXPECT_TRUE(waitFor([&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return order == sent;
  }));
  source.unsubscribe();
  thread.stop();
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].find(ns_ + "/left/mask: ignored: image encoding '32FC1' is not supported"), 0u)
      << problems[0];
}

TEST_F(LiveMasks, AFileHidesTheRobotsOwnBody) {
  const core::TemporaryFolder folder("corrsel_mask");
  const std::string file = (folder.path() / "body.png").string();
  cv::Mat body(120, 160, CV_8UC1, cv::Scalar(255));  // half of the size of the images
  body.colRange(0, 50).setTo(0);
  ASSERT_TRUE(cv::imwrite(file, body));
  set(matcher() + "/left_mask_file", file);
  set(matcher() + "/right_mask_file", std::string("/no/such/file.png"));
  Log log;
  start();
  EXPECT_EQ(log.count(matcher() + "/right_mask_file is ignored: '/no/such/file.png' cannot be read"), 1u)
      << log.text();
  const ros::Time stamp = nextStamp();
  send(stamp, good_, good_);
  const CorrespondencesConstPtr found = found_->wait(stamp);
  ASSERT_TRUE(found && !found->left_x.empty());
  EXPECT_GE(*std::min_element(found->left_x.begin(), found->left_x.end()), 99.0F);
  EXPECT_LT(*std::min_element(found->right_x.begin(), found->right_x.end()), 99.0F);
  const SelectionConstPtr selection = selections_->wait(stamp);
  ASSERT_TRUE(selection);
  EXPECT_EQ(selection->mask_use, Selection::MASK_UNUSED) << "it was used when the features were found";
}

}  // namespace
}  // namespace corrsel::testing
