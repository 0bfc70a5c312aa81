#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "live_support.h"

namespace corrsel::testing {

/// FeatureMatcher and Selector in the test's process, in a namespace of their own, with cameras before and a
/// consumer behind them.
class Live : public ::testing::Test {
 protected:
  Live() : nh_("/case_" + std::to_string(++cases_)), ns_(nh_.getNamespace()) {}

  // Nodelets are unloaded while everybody they talk to is still there.
  ~Live() override { nodelets_.reset(); }

  /// Stamps never repeat, also across tests.
  static ros::Time nextStamp() {
    static std::uint32_t count = 0;
    return ros::Time(1000) + ros::Duration(0.1 * ++count);
  }

  std::string matcher() const { return ns_ + "/feature_matcher"; }
  std::string selector() const { return ns_ + "/selector"; }

  template <class Value>
  void set(const std::string& name, const Value& value) {
    ros::param::set(name, value);
  }

  /// What most tests use: fast features, and every message is wanted at once.
  void setDefaults() {
    set(matcher() + "/features", std::string("orb+orb"));
    set(matcher() + "/orb_max_features", 300);
    set(matcher() + "/diagnostic_period", 0.1);
    set(matcher() + "/warn_silence", 0.5);
    set(selector() + "/selector", std::string("gms"));
    set(selector() + "/diagnostic_period", 0.1);
  }

  void loadMatcher() { ASSERT_TRUE(nodelets_->load(matcher(), "corrsel/FeatureMatcher")); }
  void loadSelector() { ASSERT_TRUE(nodelets_->load(selector(), "corrsel/Selector")); }

  void openCameras() {
    left_ = nh_.advertise<sensor_msgs::Image>("left/image", 10);
    right_ = nh_.advertise<sensor_msgs::Image>("right/image", 10);
  }

  void openInboxes() {
    found_ = std::make_unique<Inbox<Correspondences>>(nh_, "correspondences");
    matches_ = std::make_unique<Inbox<Correspondences>>(nh_, "matches");
    selections_ = std::make_unique<Inbox<Selection>>(nh_, "selection");
    diagnostics_ = std::make_unique<Diagnostics>(nh_);
  }

  /// Starts everything and waits for the first result.
  void start() {
    setDefaults();
    openCameras();
    openInboxes();
    loadMatcher();
    loadSelector();
    ASSERT_TRUE(answers());
  }

  /// Selector alone: the test publishes the correspondences.
  void startSelector() {
    setDefaults();
    correspondences_ = nh_.advertise<Correspondences>("correspondences", 100);
    matches_ = std::make_unique<Inbox<Correspondences>>(nh_, "matches");
    selections_ = std::make_unique<Inbox<Selection>>(nh_, "selection");
    diagnostics_ = std::make_unique<Diagnostics>(nh_);
    loadSelector();
    ASSERT_TRUE(waitFor([this] {
      return correspondences_.getNumSubscribers() >= 1 && selections_->connected() && matches_->connected();
    }));
  }

  /// Sends images as they are.
  void send(const sensor_msgs::ImagePtr& left, const sensor_msgs::ImagePtr& right) {
    left_.publish(left);
    right_.publish(right);
  }

  void send(const ros::Time& stamp, const cv::Mat& left, const cv::Mat& right) {
    send(imageMsg(stamp, "left_camera_optical", "mono8", left),
         imageMsg(stamp, "right_camera_optical", "mono8", right));
  }

  /// Sends good pairs at intervals until one has a result, which shows that the pipeline works. Results of
  /// earlier pairs do not count.
  bool answers() {
    std::vector<ros::Time> probes;
    auto sent = std::chrono::steady_clock::time_point();
    return waitFor([&] {
      if (std::chrono::steady_clock::now() - sent > 100ms) {
        sent = std::chrono::steady_clock::now();
        probes.push_back(nextStamp());
        send(probes.back(), good_, good_);
      }
      return std::any_of(probes.begin(), probes.end(),
                         [this](const ros::Time& probe) { return answered(probe); });
    });
  }

  bool answered(const ros::Time& stamp) { return matches_->has(stamp) && selections_->has(stamp); }

  /// Failures that the matcher's diagnostics count; waits for the first diagnostics.
  double matcherFailures() {
    const auto number = [this] { return diagnostics_->of(matcher(), "processing").number("failures"); };
    waitFor([&] { return !std::isnan(number()); });
    return number();
  }

  /// The result of one good pair; null if none arrives.
  SelectionConstPtr ask(const cv::Mat& left, const cv::Mat& right) {
    const ros::Time stamp = nextStamp();
    send(stamp, left, right);
    return selections_->wait(stamp);
  }

  ros::NodeHandle nh_;
  const std::string ns_;
  const cv::Mat good_ = texture(320, 240, 1);
  ros::Publisher left_, right_, correspondences_;
  std::unique_ptr<Inbox<Correspondences>> found_, matches_;
  std::unique_ptr<Inbox<Selection>> selections_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<Nodelets> nodelets_ = std::make_unique<Nodelets>();

 private:
  static inline int cases_ = 0;
};

}  // namespace corrsel::testing
