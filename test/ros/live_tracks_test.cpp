// The Tracker nodelet: correspondences, selections and features of a sequence to tracks.

#include <boost/make_shared.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/temporary_folder.h"
#include "corrsel/Tracks.h"
#include "corrsel/ros/features.h"
#include "live_fixture.h"

namespace corrsel::testing {
namespace {

class LiveTracks : public Live {
 protected:
  void startTracker() {
    set(tracker() + "/diagnostic_period", 0.1);
    tracks_ = std::make_unique<Inbox<Tracks>>(nh_, "tracks");
    diagnostics_ = std::make_unique<Diagnostics>(nh_);
    ASSERT_TRUE(nodelets_->load(tracker(), "corrsel/Tracker"));
  }

  /// The Tracker alone: the test publishes its input.
  void startAlone(int max_gap) {
    set(tracker() + "/max_gap", max_gap);
    correspondences_ = nh_.advertise<Correspondences>("correspondences", 100);
    selection_ = nh_.advertise<Selection>("selection", 100);
    features_ = nh_.advertise<Features>("features", 100);
    startTracker();
    ASSERT_TRUE(waitFor([&] {
      return correspondences_.getNumSubscribers() == 1 && selection_.getNumSubscribers() == 1 &&
             features_.getNumSubscribers() == (max_gap > 0 ? 1u : 0u);
    }));
  }

  std::string tracker() const { return ns_ + "/tracker"; }

  /// Matches of feature i with feature i, i < matched, of two frames with n features each, at (10 i, 7 i^2 %
  /// 400).
  void sendMatches(const ros::Time& stamp, const ros::Time& reference, std::uint32_t n, std::uint32_t matched,
                   int width = 640, const std::string& name = "counted") {
    core::Correspondences matches;
    for (std::uint32_t i = 0; i < matched; ++i) {
      matches.add(at(i), at(i));
      matches.left_index.push_back(i);
      matches.right_index.push_back(i);
    }
    matches.left_size = matches.right_size = {width, 480};
    PairInfo info;
    info.header.stamp = stamp;
    info.right_stamp = reference;
    info.features = name;
    info.n_left_features = info.n_right_features = n;
    core::Selection selection;
    selection.mask.assign(matched, 1);
    selection.n_input = selection.n_selected = matched;
    correspondences_.publish(boost::make_shared<Correspondences>(toMsg(matches, info)));
    selection_.publish(boost::make_shared<Selection>(toMsg(selection, info, "keep_all")));
  }

  void sendFeatures(const ros::Time& stamp, std::uint32_t n) {
    core::Features features;
    features.image_size = {640, 480};
    features.descriptors.create(int(n), 8, CV_32F);
    for (std::uint32_t i = 0; i < n; ++i) {
      features.keypoints.emplace_back(at(i), 3.0F);
      core::Random random(i + 1);
      for (int k = 0; k < 8; ++k) features.descriptors.at<float>(int(i), k) = float(random.uniform(0, 99));
    }
    FeatureInfo info;
    info.header.stamp = stamp;
    info.name = "counted";
    features_.publish(boost::make_shared<Features>(toMsg(features, info)));
  }

  static cv::Point2f at(std::uint32_t i) { return {10.0F * float(i), float(7 * i * i % 400)}; }

  std::unique_ptr<Inbox<Tracks>> tracks_;
  ros::Publisher selection_, features_;
};

TEST_F(LiveTracks, FollowImagesThroughAllNodelets) {
  const Log log;
  setDefaults();
  const core::TemporaryFolder folder("tracks");
  const std::filesystem::path path = folder.path() / "tracks.csv";
  set(matcher() + "/mode", std::string("sequence"));
  set(selector() + "/selector", std::string("auto"));
  set(tracker() + "/file", path.string());
  ros::Publisher camera = nh_.advertise<sensor_msgs::Image>("image", 10);
  loadMatcher();
  loadSelector();
  startTracker();
  // The camera moves by 3 px a frame.
  const cv::Mat world = texture(480, 240, 2);
  std::vector<ros::Time> stamps;
  const auto send = [&](int k) {
    stamps.push_back(nextStamp());
    const cv::Mat view = world(cv::Rect(3 * k, 0, 320, 240));
    camera.publish(imageMsg(stamps.back(), "camera", "mono8", view.clone()));
  };
  // Until all are connected.
  ASSERT_TRUE(waitFor([&] {
    send(0);
    return waitFor([&] { return tracks_->size() > 0; }, 200ms);
  })) << diagnostics_->text();
  stamps.clear();
  for (int k = 0; k < 8; ++k) {
    send(k);
    ASSERT_TRUE(tracks_->wait(stamps.back())) << k << "\n" << diagnostics_->text();
  }
  const TracksConstPtr last = tracks_->wait(stamps.back());
  EXPECT_EQ(log.count("no features"), 0u) << log.text();  // the FeatureMatcher publishes them
  EXPECT_EQ(last->features, "orb+orb");
  EXPECT_EQ(last->width, 320u);
  EXPECT_EQ(last->previous_stamp, stamps[6]);
  EXPECT_GE(last->n_continued, 100u);
  std::size_t old = 0, right = 0, before = 0;
  for (std::size_t i = 0; i < last->id.size(); ++i) {
    EXPECT_GE(last->age[i], 2u);
    old += last->age[i] >= 8 ? 1 : 0;
    if (std::isnan(last->previous_x[i])) continue;
    ++before;
    right += std::abs(last->x[i] - last->previous_x[i] + 3) < 2 ? 1 : 0;
  }
  EXPECT_GE(old, 30u);
  EXPECT_GE(before, 100u);
  EXPECT_GE(right, before * 98 / 100);
  // The file has the sights of the tracks that are in the message, and its first frame.
  std::ifstream file(path);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(text.find("track,stamp,keypoint,x,y\n"), 0u);
  for (const std::size_t k : {std::size_t(0), std::size_t(7)}) {
    EXPECT_NE(text.find("," + std::to_string(stamps[k].toNSec()) + ","), std::string::npos) << k;
  }
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_->of(tracker(), "processing").values["tracks"].find("continued") != std::string::npos;
  })) << diagnostics_->text();
}

TEST_F(LiveTracks, WithoutGapsNoFeaturesAreMade) {
  startAlone(0);
  const ros::Time first = nextStamp(), second = nextStamp(), third = nextStamp();
  sendMatches(second, first, 30, 20);
  sendMatches(third, second, 30, 15);
  const TracksConstPtr one = tracks_->wait(second), two = tracks_->wait(third);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->id.size(), 20u);
  EXPECT_EQ(one->n_continued, 20u);
  EXPECT_EQ(one->n_begun, 10u);
  EXPECT_EQ(two->id, (std::vector<std::uint64_t>(one->id.begin(), one->id.begin() + 15)));
  EXPECT_EQ(two->age, std::vector<std::uint32_t>(15, 3));
  EXPECT_EQ(two->n_lost, 15u);
  EXPECT_EQ(two->feature_index[14], 14u);
  EXPECT_EQ(two->x[14], 140.0F);
  EXPECT_EQ(two->previous_x[14], 140.0F);
  configure(tracker(), {}, {}, {{"min_age", 4}});
  const ros::Time fourth = nextStamp();
  sendMatches(fourth, third, 30, 20);
  ASSERT_TRUE(tracks_->wait(fourth));
  EXPECT_EQ(tracks_->wait(fourth)->id.size(), 15u);
}

TEST_F(LiveTracks, FeaturesWithoutAnEarlierMatchAreLocatedByTheNextOne) {
  startAlone(0);
  const ros::Time first = nextStamp(), second = nextStamp(), third = nextStamp();
  sendMatches(second, first, 30, 10);  // says nothing of the places of 20 features,
  ASSERT_TRUE(tracks_->wait(second));
  sendMatches(third, second, 30, 30);  // which begin tracks
  const TracksConstPtr tracks = tracks_->wait(third);
  ASSERT_TRUE(tracks);
  ASSERT_EQ(tracks->id.size(), 30u);
  EXPECT_EQ(tracks->age[29], 2u);
  EXPECT_EQ(tracks->previous_x[29], 290.0F);
}

TEST_F(LiveTracks, GapsAreBridged) {
  startAlone(2);
  const ros::Time first = nextStamp(), second = nextStamp(), third = nextStamp(), fourth = nextStamp();
  for (const ros::Time& stamp : {first, second}) sendFeatures(stamp, 40);
  sendMatches(second, first, 40, 40);
  const TracksConstPtr before = tracks_->wait(second);
  ASSERT_TRUE(before);
  for (const ros::Time& stamp : {third, fourth}) sendFeatures(stamp, 40);
  sendMatches(third, second, 40, 25);  // 15 tracks are lost, because their matches were not selected,
  ASSERT_TRUE(tracks_->wait(third));
  EXPECT_EQ(tracks_->wait(third)->n_lost, 15u);
  sendMatches(fourth, third, 40, 25);  // and found again
  const TracksConstPtr after = tracks_->wait(fourth);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->n_bridged, 15u);
  EXPECT_EQ(after->id, before->id);
  EXPECT_EQ(after->age[0], 4u);
  EXPECT_EQ(after->age[39], 3u);
  EXPECT_TRUE(std::isnan(after->previous_x[39]));
}

TEST_F(LiveTracks, AFrameWhoseSelectionWasDroppedEndsNoTrack) {
  startAlone(2);
  const ros::Time first = nextStamp(), second = nextStamp(), third = nextStamp(), fourth = nextStamp();
  for (const ros::Time& stamp : {first, second, third, fourth}) sendFeatures(stamp, 40);
  sendMatches(second, first, 40, 40);
  ASSERT_TRUE(tracks_->wait(second));
  sendMatches(fourth, third, 40, 40);  // of the third frame there is no selection
  const TracksConstPtr after = tracks_->wait(fourth);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->id, tracks_->wait(second)->id);
  EXPECT_EQ(after->age, std::vector<std::uint32_t>(40, 4));
}

TEST_F(LiveTracks, ATimeBeforeAnotherSizeAndOtherFeaturesBeginNewTracks) {
  startAlone(0);
  std::vector<ros::Time> stamps;
  for (int k = 0; k < 9; ++k) stamps.push_back(nextStamp());
  sendMatches(stamps[4], stamps[3], 5, 5);
  ASSERT_TRUE(tracks_->wait(stamps[4]));
  std::uint64_t newest = tracks_->wait(stamps[4])->id.back();
  const auto begins = [&](const ros::Time& stamp) {
    const TracksConstPtr tracks = tracks_->wait(stamp);
    ASSERT_TRUE(tracks);
    ASSERT_EQ(tracks->id.size(), 5u);
    EXPECT_GT(tracks->id.front(), newest);
    EXPECT_EQ(tracks->age.front(), 2u);
    newest = tracks->id.back();
  };
  sendMatches(stamps[1], stamps[0], 5, 5);
  begins(stamps[1]);
  sendMatches(stamps[2], stamps[1], 5, 5, 320);
  begins(stamps[2]);
  sendMatches(stamps[3], stamps[2], 5, 5, 320, "others");
  begins(stamps[3]);
}

TEST_F(LiveTracks, WhatIsWrongIsReportedAndTracksGoOn) {
  const Log log;
  set(tracker() + "/file", std::string("/dev/full"));
  startAlone(2);
  EXPECT_EQ(log.count("/dev/full cannot be written"), 1u) << log.text();
  const ros::Time first = nextStamp(), second = nextStamp(), third = nextStamp(), fourth = nextStamp();
  sendMatches(second, first, 20, 20);
  ASSERT_TRUE(tracks_->wait(second));
  EXPECT_TRUE(waitFor([&] { return log.count("no features with the stamp") == 1; })) << log.text();
  sendFeatures(third, 7);  // of other features than the matches
  sendMatches(third, second, 20, 20);
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_->of(tracker(), "processing").values["last failure"].find("7 keypoints") !=
           std::string::npos;
  })) << diagnostics_->text();
  sendMatches(fourth, second, 20, 20);
  ASSERT_TRUE(tracks_->wait(fourth));
  EXPECT_EQ(tracks_->wait(fourth)->id, tracks_->wait(second)->id);
  EXPECT_FALSE(tracks_->has(third));
  EXPECT_EQ(configure(tracker(), {{"selector", "no_such_selector"}})["selector"], "auto");
}

}  // namespace
}  // namespace corrsel::testing
