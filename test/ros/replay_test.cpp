// Sends pairs through the nodelets of launch/replay.test and compares what comes out with what the core
// computes.

#include <gtest/gtest.h>
#include <nodelet/NodeletList.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "corrsel/evaluation/errors.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/random.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/selectors/factory.h"
#include "live_support.h"

namespace corrsel {
namespace {

using testing::configure;
using testing::Inbox;
using testing::texture;
using testing::waitFor;
using namespace std::chrono_literals;

core::GroundTruth exampleTruth() {
  core::GroundTruth truth;
  truth.kind = core::TruthKind::kHomography;
  truth.matrix = cv::Matx33d(0.95, 0.05, 12, -0.04, 1.02, 7, 1e-5, -2e-5, 1);
  return truth;
}

/// Evenly spread inliers with small errors and good ratios among random outliers, and a row that is not
/// finite.
core::Correspondences exampleMatches(std::uint64_t seed) {
  core::Random random(seed);
  const cv::Matx33d h = exampleTruth().matrix;
  core::Correspondences matches;
  matches.left_size = {640, 480};
  matches.right_size = {700, 520};
  const auto add = [&](const cv::Point2f& left, const cv::Point2f& right, double ratio) {
    matches.left_x.push_back(left.x);
    matches.left_y.push_back(left.y);
    matches.right_x.push_back(right.x);
    matches.right_y.push_back(right.y);
    matches.second_distance.push_back(200.0F);
    matches.distance.push_back(static_cast<float>(200.0 * ratio));
    // The frame of an outlier may be turned any way.
    const double angle = ratio < 0.7 ? 0.0 : random.uniform(0, 2 * CV_PI);
    const cv::Matx22d turn(std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle));
    const cv::Matx22f frame = turn * cv::Matx22d(h(0, 0), h(0, 1), h(1, 0), h(1, 1));
    matches.left_frame.push_back({1, 0, left.x, 0, 1, left.y});
    matches.right_frame.push_back({frame(0, 0), frame(0, 1), right.x, frame(1, 0), frame(1, 1), right.y});
  };
  for (int i = 0; i < 3000; ++i) {
    const auto y = static_cast<float>(random.uniform(0, 480)), x = static_cast<float>(random.uniform(0, 640));
    const cv::Point2f left(x, y);
    if (i % 3 == 0) {
      const double ratio = random.uniform(0.7, 1.0);
      add(left, {static_cast<float>(random.uniform(0, 700)), static_cast<float>(random.uniform(0, 520))},
          ratio);
      continue;
    }
    const cv::Vec3d right = h * cv::Vec3d(left.x, left.y, 1.0);
    const double ratio = random.uniform(0.2, 0.75);
    add(left,
        {static_cast<float>(right[0] / right[2] + random.normal()),
         static_cast<float>(right[1] / right[2] + random.normal())},
        ratio);
  }
  add({std::nanf(""), 5.0F}, {6.0F, 7.0F}, 0.1);
  return matches;
}

template <class Number>
bool same(const Number& a, const Number& b) {
  return a == b || (a != a && b != b);
}

template <class Numbers>
bool sameAll(const Numbers& a, const Numbers& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), same<typename Numbers::value_type>);
}

class Replay : public ::testing::Test {
 protected:
  void SetUp() override {
    correspondences_ = nh_.advertise<Correspondences>("correspondences", 50);
    truth_ = nh_.advertise<GroundTruth>("ground_truth", 50);
    selections_ = std::make_unique<Inbox<Selection>>(nh_, "selection");
    matches_ = std::make_unique<Inbox<Correspondences>>(nh_, "matches");
    scores_ = std::make_unique<Inbox<Score>>(nh_, "score");
    ASSERT_TRUE(waitFor([this] {
      return correspondences_.getNumSubscribers() >= 1 && truth_.getNumSubscribers() >= 1 &&
             selections_->connected() && matches_->connected() && scores_->connected();
    }));
    // Nodelets of one manager share their connections, so these do not tell whether all of them listen. An
    // answer that has passed through selector and evaluator does.
    std::vector<ros::Time> probes;
    ASSERT_TRUE(waitFor([&] {
      probes.push_back(nextStamp());
      const PairInfo info = infoAt(probes.back());
      truth_.publish(toMsg(exampleTruth(), info));
      correspondences_.publish(toMsg(core::Correspondences(), info));
      std::this_thread::sleep_for(50ms);
      return std::any_of(probes.begin(), probes.end(), [this](const ros::Time& probe) {
        return selections_->has(probe) && matches_->has(probe) && scores_->has(probe);
      });
    }));
  }

  /// Stamps never repeat, also across tests.
  static ros::Time nextStamp() {
    static std::uint32_t seconds = 100;
    return ros::Time(++seconds, 500);
  }

  static PairInfo infoAt(const ros::Time& stamp) {
    PairInfo info;
    info.header.stamp = stamp;
    info.header.frame_id = "left_camera_optical";
    info.right_stamp = stamp + ros::Duration(0.01);
    info.right_frame_id = "right_camera_optical";
    info.id = {"made_up", "scene", std::to_string(stamp.sec)};
    info.features = "given";
    return info;
  }

  /// Sends a pair to the selector and compares selection, matches and score with the core's.
  void expectAnswerOf(const std::string& spec, const core::OptionMap& options = {}) {
    SCOPED_TRACE(spec);
    const ros::Time stamp = nextStamp();
    const PairInfo info = infoAt(stamp);
    const core::Correspondences matches = exampleMatches(stamp.sec);
    truth_.publish(toMsg(exampleTruth(), info));
    correspondences_.publish(toMsg(matches, info));

    const core::Selection expected = core::createSelector(spec, options, {{"seed", "7"}})->select(matches);
    ASSERT_GT(expected.n_selected, 100u) << expected.message;
    ASSERT_LT(expected.n_selected, matches.size());

    const SelectionConstPtr selection = selections_->wait(stamp);
    ASSERT_TRUE(selection);
    EXPECT_EQ(selection->selector, spec);
    EXPECT_EQ(selection->status, Selection::STATUS_OK) << selection->message;
    EXPECT_EQ(selection->mask, expected.mask);
    EXPECT_TRUE(sameAll(selection->score, expected.score));
    EXPECT_EQ(selection->n_ignored, 1u);
    EXPECT_EQ(selection->right_stamp, info.right_stamp);
    EXPECT_EQ(selection->right_frame_id, info.right_frame_id);
    EXPECT_GT(selection->seconds.select, 0.0);

    const CorrespondencesConstPtr kept = matches_->wait(stamp);
    ASSERT_TRUE(kept);
    const core::Correspondences subset = matches.subset(core::selectedRows(expected.mask));
    EXPECT_EQ(kept->left_x, subset.left_x);
    EXPECT_EQ(kept->right_y, subset.right_y);
    EXPECT_EQ(kept->distance, subset.distance);
    EXPECT_EQ(kept->left_width, 640u);
    EXPECT_EQ(kept->features, "given");

    const ScoreConstPtr score = scores_->wait(stamp);
    ASSERT_TRUE(score);
    core::EvaluationOptions evaluation_options;
    evaluation_options.tolerances = {1, 3, 5};
    evaluation_options.ground_truth_tolerance = 5;
    ScoreLabels labels;
    labels.pair = info;
    const Score expected_score =
        toMsg(core::evaluate(core::TruthKind::kHomography, core::groundTruthErrors(exampleTruth(), matches),
                             expected.mask, evaluation_options),
              labels);
    EXPECT_EQ(score->selector, spec);
    EXPECT_EQ(score->pair, info.id.pair);
    EXPECT_EQ(score->n_putative, expected_score.n_putative);
    EXPECT_EQ(score->n_ground_truth, expected_score.n_ground_truth);
    EXPECT_EQ(score->n_selected, expected_score.n_selected);
    EXPECT_EQ(score->tolerance, expected_score.tolerance);
    EXPECT_EQ(score->n_correct, expected_score.n_correct);
    EXPECT_TRUE(sameAll(score->precision, expected_score.precision));
    EXPECT_TRUE(sameAll(score->recall_paper, expected_score.recall_paper));
    EXPECT_TRUE(sameAll(score->recall_same_tau, expected_score.recall_same_tau));
    EXPECT_TRUE(sameAll(score->f_paper, expected_score.f_paper));
    EXPECT_TRUE(sameAll(score->f_same_tau, expected_score.f_same_tau));
    EXPECT_GT(score->f_same_tau.back(), 0.5);
  }

  ros::NodeHandle nh_;
  ros::Publisher correspondences_, truth_;
  std::unique_ptr<Inbox<Selection>> selections_;
  std::unique_ptr<Inbox<Correspondences>> matches_;
  std::unique_ptr<Inbox<Score>> scores_;
};

// First: what the launch file asks for is in force before anybody reconfigures.
TEST_F(Replay, LaunchFileChoosesTheSelector) { expectAnswerOf("nnsr"); }

TEST_F(Replay, EverySelectorAnswersAsTheCoreDoes) {
  for (const std::string& selector : core::selectorNames()) {
    EXPECT_EQ(configure("selector", {{"selector", selector}})["selector"], selector);
    if (selector == "pose") continue;  // needs cameras, which live_test sends
    expectAnswerOf(selector);
  }
}

// The nodelet does not link corrsel::reference, while this program does.
TEST_F(Replay, ReferenceSelectorsAreLoadedAndTheirOptionsChange) {
  core::addReferenceSelectors();
  for (const core::SelectorFactory& selector : core::builtInSelectors()) {
    if (selector.group() != core::SelectorGroup::kReference) continue;
    EXPECT_EQ(configure("selector", {{"selector", selector.name()}})["selector"], selector.name());
    expectAnswerOf(selector.name());
  }
  const core::Correspondences matches = exampleMatches(1);
  EXPECT_NE(core::createSelector("lap")->select(matches).mask,
            core::createSelector("lap", {{"lambda", "1.4"}})->select(matches).mask);
  configure("selector", {{"selector", "lap"}, {"options", "lambda=1.4"}});
  expectAnswerOf("lap", {{"lambda", "1.4"}});
  configure("selector", {{"options", ""}});
  expectAnswerOf("lap");
  configure("selector", {{"selector", "tlinkage"}, {"preset", "motions"}});
  expectAnswerOf("tlinkage:motions");
  configure("selector", {{"selector", "nnsr"}, {"preset", ""}});
}

TEST_F(Replay, OptionsChangeWhileFramesFlow) {
  configure("selector", {{"selector", "gms"}}, {{"gms_alpha", 8.0}});
  expectAnswerOf("gms", {{"alpha", "8"}});
  configure("selector", {}, {{"gms_alpha", 4.0}});
  expectAnswerOf("gms");
}

TEST_F(Replay, PresetsAreAppliedAndDoNotOutliveTheirSelector) {
  configure("selector", {{"selector", "lpm"}, {"preset", "v2"}});
  expectAnswerOf("lpm:v2");
  EXPECT_EQ(configure("selector", {{"selector", "gms"}})["preset"], "");
  expectAnswerOf("gms");
}

TEST_F(Replay, InvalidChangesAreRefused) {
  configure("selector", {{"selector", "gms"}, {"preset", ""}});
  EXPECT_EQ(configure("selector", {{"selector", "no_such_selector"}})["selector"], "gms");
  EXPECT_EQ(configure("selector", {{"preset", "no_such_preset"}})["preset"], "");
  expectAnswerOf("gms");
  // Each in its range, together nonsense.
  EXPECT_EQ(configure("selector", {{"selector", "nnsr"}},
                      {{"nnsr_min_threshold", 0.9}, {"nnsr_max_threshold", 0.1}})["selector"],
            "gms");
  expectAnswerOf("gms");
}

TEST_F(Replay, MalformedMessagesAreDropped) {
  configure("selector", {{"selector", "gms"}, {"preset", ""}});
  Correspondences broken = toMsg(exampleMatches(1), infoAt(nextStamp()));
  broken.left_y.pop_back();
  correspondences_.publish(broken);
  GroundTruth truth = toMsg(exampleTruth(), infoAt(broken.header.stamp));
  truth.kind = 99;
  truth_.publish(truth);
  expectAnswerOf("gms");  // which comes after it on the same connection
  EXPECT_FALSE(selections_->has(broken.header.stamp));
  EXPECT_FALSE(scores_->has(broken.header.stamp));
}

TEST_F(Replay, NoMatchesAreAnAnswer) {
  configure("selector", {{"selector", "ransac"}, {"preset", ""}});
  const ros::Time stamp = nextStamp();
  correspondences_.publish(toMsg(core::Correspondences(), infoAt(stamp)));
  const SelectionConstPtr selection = selections_->wait(stamp);
  ASSERT_TRUE(selection);
  EXPECT_TRUE(selection->mask.empty());
  EXPECT_EQ(selection->status, Selection::STATUS_TOO_FEW);
  for (const double number : selection->model) EXPECT_TRUE(std::isnan(number));
}

class Matcher : public Replay {
 protected:
  void SetUp() override {
    Replay::SetUp();
    left_ = nh_.advertise<sensor_msgs::Image>("left/image", 10);
    right_ = nh_.advertise<sensor_msgs::Image>("right/image", 10);
    found_ = std::make_unique<Inbox<Correspondences>>(nh_, "found/correspondences");
    ASSERT_TRUE(waitFor([this] {
      return found_->connected() && left_.getNumSubscribers() >= 1 && right_.getNumSubscribers() >= 1;
    }));
  }

  void send(const ros::Time& stamp, const std::string& left_encoding, const cv::Mat& left,
            const std::string& right_encoding, const cv::Mat& right) {
    std_msgs::Header header;
    header.stamp = stamp;
    header.frame_id = "left_camera_optical";
    left_.publish(cv_bridge::CvImage(header, left_encoding, left).toImageMsg());
    header.frame_id = "right_camera_optical";
    right_.publish(cv_bridge::CvImage(header, right_encoding, right).toImageMsg());
  }

  /// The matches of the core for the same images.
  static core::Correspondences offline(const std::string& features, const core::OptionMap& options,
                                       const cv::Mat& left, const cv::Mat& right,
                                       const core::MatchOptions& match = {}) {
    const auto extractor = core::createExtractor(features, {{core::algorithmsOf(features).front(), options}});
    const auto pair = core::extractPair(*extractor, left, right, 1);
    return core::matchFeatures(pair.first, pair.second, match);
  }

  void expectMatches(const ros::Time& stamp, const std::string& features,
                     const core::Correspondences& expected) {
    const CorrespondencesConstPtr msg = found_->wait(stamp);
    ASSERT_TRUE(msg);
    EXPECT_EQ(msg->features, features);
    EXPECT_EQ(msg->header.frame_id, "left_camera_optical");
    EXPECT_EQ(msg->right_frame_id, "right_camera_optical");
    EXPECT_EQ(msg->right_stamp, stamp);
    EXPECT_TRUE(msg->seconds.detect >= 0.0);
    EXPECT_TRUE(msg->seconds.describe >= 0.0);
    EXPECT_TRUE(msg->seconds.match >= 0.0);
    const core::Correspondences actual = fromMsg(*msg);
    EXPECT_EQ(actual.left_size, expected.left_size);
    EXPECT_EQ(actual.right_size, expected.right_size);
    EXPECT_EQ(actual.left_x, expected.left_x);
    EXPECT_EQ(actual.left_y, expected.left_y);
    EXPECT_EQ(actual.right_x, expected.right_x);
    EXPECT_EQ(actual.right_y, expected.right_y);
    EXPECT_EQ(actual.distance, expected.distance);
    EXPECT_TRUE(sameAll(actual.second_distance, expected.second_distance));
    EXPECT_EQ(actual.left_frame, expected.left_frame);
    EXPECT_EQ(actual.right_index, expected.right_index);
  }

  const core::OptionMap live_options_ = {{"max_features", "1000"}};  // the default of live use
  const core::OptionMap orb_options_ = {{"max_features", "500"}, {"levels", "16"}};  // as launched, clamped
  ros::Publisher left_, right_;
  std::unique_ptr<Inbox<Correspondences>> found_;
};

TEST_F(Matcher, FindsWhatTheCoreFinds) {
  const cv::Mat left = texture(320, 240, 1);
  cv::Mat right;
  cv::warpPerspective(left, right, exampleTruth().matrix, {360, 260});
  for (const auto& [features, options] : {std::pair<std::string, core::OptionMap>{"orb+orb", orb_options_},
                                          {"sift+sift", live_options_},
                                          {"hessian_affine+sift", live_options_},
                                          {"blob+freak", live_options_},
                                          {"asift+asift", live_options_},
                                          {"akaze+akaze", live_options_},
                                          {"brisk+brisk", live_options_},
                                          {"sift+freak", live_options_}}) {
    SCOPED_TRACE(features);
    EXPECT_EQ(configure("feature_matcher", {{"features", features}})["features"], features);
    const ros::Time stamp = nextStamp();
    send(stamp, "mono8", left, "mono8", right);
    const core::Correspondences expected = offline(features, options, left, right);
    ASSERT_GT(expected.size(), 20u);
    expectMatches(stamp, features, expected);
  }
}

TEST_F(Matcher, MatchingIsReconfigured) {
  const cv::Mat left = texture(320, 240, 1), right = texture(320, 240, 5);
  configure("feature_matcher", {{"features", "orb+orb"}, {"match_mutual", "true"}});
  const ros::Time stamp = nextStamp();
  send(stamp, "mono8", left, "mono8", right);
  core::MatchOptions match;
  match.mutual = true;
  const core::Correspondences expected = offline("orb+orb", orb_options_, left, right, match);
  EXPECT_LT(expected.size(), offline("orb+orb", orb_options_, left, right).size());
  expectMatches(stamp, "orb+orb", expected);
  configure("feature_matcher", {{"match_mutual", "false"}});
}

TEST_F(Matcher, ImpossiblePairingsAreRefused) {
  configure("feature_matcher", {{"features", "orb+orb"}});
  EXPECT_EQ(configure("feature_matcher", {{"features", "orb+akaze"}})["features"], "orb+orb");
}

TEST_F(Matcher, EncodingsMayDiffer) {
  configure("feature_matcher", {{"features", "orb+orb"}});
  const cv::Mat left = texture(320, 240, 2);
  cv::Mat rgb, bgr, deep;
  cv::cvtColor(texture(300, 260, 2), bgr, cv::COLOR_GRAY2BGR);
  cv::applyColorMap(bgr, bgr, cv::COLORMAP_JET);
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  left.convertTo(deep, CV_16U, 65535.0 / 255.0);
  const ros::Time stamp = nextStamp();
  send(stamp, "mono16", deep, "rgb8", rgb);
  expectMatches(stamp, "orb+orb", offline("orb+orb", orb_options_, left, bgr));
}

TEST_F(Matcher, BlankImagesGiveNoMatches) {
  configure("feature_matcher", {{"features", "orb+orb"}});
  const ros::Time stamp = nextStamp();
  const cv::Mat blank(240, 320, CV_8UC1, cv::Scalar(0));
  send(stamp, "mono8", blank, "mono8", blank);
  const CorrespondencesConstPtr msg = found_->wait(stamp);
  ASSERT_TRUE(msg);
  EXPECT_TRUE(msg->left_x.empty());
  EXPECT_EQ(msg->n_left_features, 0u);
  EXPECT_EQ(msg->left_width, 320u);
}

TEST_F(Matcher, GarbageIsDropped) {
  configure("feature_matcher", {{"features", "orb+orb"}});
  const cv::Mat good = texture(320, 240, 3);
  const ros::Time floats = nextStamp(), empty = nextStamp(), after = nextStamp();
  send(floats, "mono8", good, "32FC1", cv::Mat(240, 320, CV_32FC1, cv::Scalar(0)));
  send(empty, "mono8", cv::Mat(), "mono8", good);
  send(after, "mono8", good, "mono8", good);
  expectMatches(after, "orb+orb", offline("orb+orb", orb_options_, good, good));
  EXPECT_FALSE(found_->has(floats));
  EXPECT_FALSE(found_->has(empty));
}

TEST_F(Matcher, UnknownFeaturesAreRefused) {
  configure("feature_matcher", {{"features", "orb+orb"}});
  EXPECT_EQ(configure("feature_matcher", {{"features", "surf+surf"}})["features"], "orb+orb");
  const cv::Mat image = texture(320, 240, 4);
  const ros::Time stamp = nextStamp();
  send(stamp, "mono8", image, "mono8", image);
  expectMatches(stamp, "orb+orb", offline("orb+orb", orb_options_, image, image));
}

TEST_F(Matcher, LazyMeansNoSubscriptionWithoutNeed) {
  found_.reset();
  EXPECT_TRUE(waitFor([this] { return left_.getNumSubscribers() == 0 && right_.getNumSubscribers() == 0; }));
}

TEST_F(Matcher, ViewerDrawsWhileSomebodyLooks) {
  found_.reset();  // only the viewer shall subscribe to the images
  ASSERT_TRUE(waitFor([this] { return left_.getNumSubscribers() == 0; }));
  {
    Inbox<sensor_msgs::Image> pictures(nh_, "matches/image");
    ASSERT_TRUE(waitFor([&] {
      return pictures.connected() && left_.getNumSubscribers() == 1 && right_.getNumSubscribers() == 1;
    }));
    configure("selector", {{"selector", "gms"}, {"preset", ""}});
    const ros::Time stamp = nextStamp();
    const PairInfo info = infoAt(stamp);
    truth_.publish(toMsg(exampleTruth(), info));
    correspondences_.publish(toMsg(exampleMatches(5), info));
    std_msgs::Header header = info.header;
    left_.publish(cv_bridge::CvImage(header, "mono8", texture(640, 480, 5)).toImageMsg());
    header.stamp = info.right_stamp;  // the right image has a stamp of its own
    right_.publish(cv_bridge::CvImage(header, "mono8", texture(700, 520, 6)).toImageMsg());
    const sensor_msgs::ImageConstPtr picture = pictures.wait(stamp);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->encoding, "bgr8");
    EXPECT_EQ(picture->width, 1340u);
    EXPECT_EQ(picture->height, 520u);
    EXPECT_EQ(picture->header.frame_id, info.header.frame_id);
  }
  EXPECT_TRUE(waitFor([this] { return left_.getNumSubscribers() == 0 && right_.getNumSubscribers() == 0; }));
}

class AfterAllThis : public Replay {};

TEST_F(AfterAllThis, EveryNodeletIsAliveAndWorks) {
  nodelet::NodeletList list;
  ASSERT_TRUE(ros::service::call("manager/list", list));
  std::sort(list.response.nodelets.begin(), list.response.nodelets.end());
  EXPECT_EQ(list.response.nodelets,
            (std::vector<std::string>{"/evaluator", "/feature_matcher", "/match_viewer", "/selector"}));
  configure("selector", {{"selector", "lpm"}, {"preset", ""}});
  expectAnswerOf("lpm");
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "replay_test");
  ros::NodeHandle nh;  // keeps ROS running from the first to the last test
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
