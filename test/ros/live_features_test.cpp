// The Matcher nodelet: features of two cameras, or of one, to correspondences.

#include <boost/make_shared.hpp>

#include "corrsel/ros/features.h"
#include "live_fixture.h"

namespace corrsel::testing {
namespace {

class LiveFeatures : public Live {
 protected:
  void start(const std::string& mode) {
    set(nodelet() + "/mode", mode);
    set(nodelet() + "/diagnostic_period", 0.1);
    set(nodelet() + "/pending", 10);  // nothing is dropped
    const bool pair = mode == "pair";
    left_features_ = nh_.advertise<Features>(pair ? "left/features" : "features", 10);
    if (pair) right_features_ = nh_.advertise<Features>("right/features", 10);
    found_ = std::make_unique<Inbox<Correspondences>>(nh_, "correspondences");
    diagnostics_ = std::make_unique<Diagnostics>(nh_);
    ASSERT_TRUE(nodelets_->load(nodelet(), "corrsel/Matcher"));
    ASSERT_TRUE(waitFor([&] {
      return left_features_.getNumSubscribers() == 1 && (!pair || right_features_.getNumSubscribers() == 1);
    }));
  }

  std::string nodelet() const { return ns_ + "/matcher"; }

  /// Features with the descriptors 1 to n in one column, and the points (shift + i, 3).
  static FeaturesPtr features(const ros::Time& stamp, int shift, int n = 5) {
    core::Features features;
    features.image_size = {640, 480};
    features.descriptors.create(n, 1, CV_32F);
    for (int i = 0; i < n; ++i) {
      features.keypoints.emplace_back(static_cast<float>(shift + i), 3.0F, 1.0F);
      features.descriptors.at<float>(i, 0) = static_cast<float>(i + 1);
    }
    FeatureInfo info;
    info.header.stamp = stamp;
    info.name = "counted";
    return boost::make_shared<Features>(toMsg(features, info));
  }

  ros::Publisher left_features_, right_features_;
};

TEST_F(LiveFeatures, PairsHaveEqualStampsWhateverComesFirst) {
  start("pair");
  const ros::Time first = nextStamp(), lonely = nextStamp(), second = nextStamp();
  left_features_.publish(features(first, 0));
  right_features_.publish(features(first, 10));
  left_features_.publish(features(lonely, 0));
  right_features_.publish(features(second, 20));
  left_features_.publish(features(second, 0));
  const CorrespondencesConstPtr one = found_->wait(first), two = found_->wait(second);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->left_x, (std::vector<float>{0, 1, 2, 3, 4}));
  EXPECT_EQ(one->right_x, (std::vector<float>{10, 11, 12, 13, 14}));
  EXPECT_EQ(one->right_stamp, first);
  EXPECT_EQ(two->right_x[0], 20);
  EXPECT_FALSE(found_->has(lonely));
}

TEST_F(LiveFeatures, ABagThatStartsAgainGoesOn) {
  start("pair");
  const ros::Time early = nextStamp(), late = nextStamp();
  for (const ros::Time& stamp : {late, early}) {
    left_features_.publish(features(stamp, 0));
    right_features_.publish(features(stamp, 10));
    EXPECT_TRUE(found_->wait(stamp)) << stamp;
  }
}

TEST_F(LiveFeatures, SequencesBeginWithTheSecondFrame) {
  start("sequence");
  const ros::Time first = nextStamp(), second = nextStamp();
  left_features_.publish(features(first, 0));
  left_features_.publish(features(second, 30));
  const CorrespondencesConstPtr message = found_->wait(second);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->left_x[0], 30);
  EXPECT_EQ(message->right_x[0], 0);
  EXPECT_EQ(message->right_stamp, first);
  EXPECT_FALSE(found_->has(first));
}

TEST_F(LiveFeatures, BadMessagesAreReportedAndGoodOnesFollow) {
  start("pair");
  const Log log;
  const ros::Time bad = nextStamp(), good = nextStamp();
  const FeaturesPtr damaged = features(bad, 0);
  damaged->descriptors.pop_back();
  left_features_.publish(damaged);
  right_features_.publish(features(bad, 10));
  EXPECT_TRUE(waitFor([&] { return log.count("descriptors has 19 bytes, expected 5 rows") == 1; }))
      << log.text();
  left_features_.publish(features(good, 0));
  right_features_.publish(features(good, 10));
  EXPECT_TRUE(found_->wait(good));
  EXPECT_FALSE(found_->has(bad));
  const auto failures = [this] { return diagnostics_->of(nodelet(), "processing").number("failures"); };
  EXPECT_TRUE(waitFor([&] { return failures() == 1; })) << diagnostics_->text();
}

}  // namespace
}  // namespace corrsel::testing
