#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "corrsel/tracking/track_keeper.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// A frame with n features: feature i is at (i, id).
TrackKeeper::Frame frame(std::uint64_t id, std::size_t n, bool with_features = false) {
  TrackKeeper::Frame frame;
  frame.id = id;
  for (std::size_t i = 0; i < n; ++i) frame.points.emplace_back(float(i), float(id));
  if (with_features) {
    auto features = std::make_shared<Features>();
    features->keypoints.resize(n);
    frame.features = features;
  }
  return frame;
}

std::vector<std::uint64_t> ids(const TrackKeeper& keeper) {
  std::vector<std::uint64_t> result;
  for (const FeatureTrack& track : keeper.tracks()) result.push_back(track.id);
  return result;
}

std::vector<std::uint32_t> ages(const TrackKeeper& keeper) {
  std::vector<std::uint32_t> result;
  for (const FeatureTrack& track : keeper.tracks()) result.push_back(track.age);
  return result;
}

TEST(TrackKeeper, IdentitiesLast) {
  TrackKeeper keeper;
  keeper.add(frame(1, 3));
  const std::vector<std::uint64_t> first = ids(keeper);
  EXPECT_EQ(std::set<std::uint64_t>(first.begin(), first.end()).size(), 3u);
  EXPECT_EQ(ages(keeper), (std::vector<std::uint32_t>{1, 1, 1}));
  keeper.add(frame(2, 3), 1, {{0, 2, 0}, {2, 0, 0}});
  EXPECT_EQ(ids(keeper)[0], first[2]);
  EXPECT_EQ(ids(keeper)[2], first[0]);
  EXPECT_EQ(ages(keeper), (std::vector<std::uint32_t>{2, 1, 2}));
  keeper.add(frame(3, 2), 2, {{1, 0, 0}});
  const FeatureTrack track = keeper.tracks()[1];
  EXPECT_EQ(track.id, first[2]);
  EXPECT_EQ(track.age, 3u);
  EXPECT_EQ(track.first.frame, 1u);
  EXPECT_EQ(track.first.feature, 2u);
  EXPECT_EQ(track.first.point, cv::Point2f(2, 1));
  EXPECT_EQ(track.point, cv::Point2f(1, 3));
  EXPECT_EQ(track.previous, cv::Point2f(0, 2));
  const TrackKeeper::Counts& counts = keeper.counts();
  EXPECT_EQ(counts.continued, 1u);
  EXPECT_EQ(counts.bridged, 0u);
  EXPECT_EQ(counts.begun, 1u);
  EXPECT_EQ(counts.cut, 0u);
  EXPECT_EQ(counts.lost, 2u);
}

TEST(TrackKeeper, ATrackHasOneFeatureInAFrame) {
  TrackKeeper keeper;
  keeper.add(frame(1, 3));
  const std::vector<std::uint64_t> first = ids(keeper);
  // Features 0 and 1 want feature 0, and feature 2 wants features 1 and 2. NaN is the worst.
  keeper.add(frame(2, 3), 1, {{0, 0, 2}, {1, 0, 1}, {2, 1, kNaN}, {2, 2, 5}});
  EXPECT_EQ(ids(keeper)[1], first[0]);
  EXPECT_EQ(ids(keeper)[2], first[2]);
  EXPECT_EQ(ages(keeper), (std::vector<std::uint32_t>{1, 2, 2}));
  EXPECT_EQ(keeper.counts().cut, 2u);
  EXPECT_EQ(keeper.counts().continued, 2u);
}

TEST(TrackKeeper, TheOrderOfTheLinksDoesNotMatter) {
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<FeatureLink> links;
    for (int i = 0; i < 40; ++i) {
      const std::uint32_t newest = random.index(20), earlier = random.index(20);
      links.push_back({newest, earlier, float(random.index(4))});  // many equal costs
    }
    TrackKeeper one, other;
    one.add(frame(1, 20));
    other.add(frame(1, 20));
    one.add(frame(2, 20), 1, links);
    for (std::size_t i = links.size(); i > 1; --i) {
      std::swap(links[i - 1], links[random.index(std::uint32_t(i))]);
    }
    other.add(frame(2, 20), 1, links);
    ASSERT_EQ(ids(one), ids(other));
    ASSERT_EQ(one.counts().cut, other.counts().cut);
    std::set<std::uint64_t> distinct;
    for (const std::uint64_t id : ids(one)) ASSERT_TRUE(distinct.insert(id).second) << id;
  }
}

TEST(TrackKeeper, AKeyframeStaysHoweverOldItIs) {
  TrackKeeper keeper(0, {}, 4);
  keeper.add(frame(1, 2));
  const std::uint64_t id = ids(keeper)[0];
  for (std::uint64_t k = 2; k <= 50; ++k) {
    keeper.add(frame(k, 2), 1, {{1, 0, 0}});
    ASSERT_EQ(ids(keeper)[1], id);
    ASSERT_EQ(ages(keeper)[1], k);
    // Also in the frame before; the keyframe itself is the frame before the second one.
    ASSERT_EQ(keeper.tracks()[1].previous, cv::Point2f(k == 2 ? 0 : 1, float(k - 1)));
  }
  EXPECT_TRUE(keeper.knows(1));
  EXPECT_FALSE(keeper.knows(40));
  // A new keyframe: the old one is forgotten with its track.
  for (std::uint64_t k = 51; k < 60; ++k) keeper.add(frame(k, 2), 50, {{0, 0, 0}});
  EXPECT_FALSE(keeper.knows(1));
  EXPECT_TRUE(keeper.knows(50));
}

TEST(TrackKeeper, FramesSomeStepsAgoGiveTracksSideBySide) {
  TrackKeeper keeper;
  keeper.add(frame(1, 1));
  keeper.add(frame(2, 1));
  keeper.add(frame(3, 1), 1, {{0, 0, 0}});
  EXPECT_EQ(ids(keeper)[0], 1u);
  EXPECT_TRUE(std::isnan(keeper.tracks()[0].previous.x));  // not seen in frame 2
  keeper.add(frame(4, 1), 2, {{0, 0, 0}});
  EXPECT_EQ(ids(keeper)[0], 2u);
  keeper.add(frame(5, 1), 3, {{0, 0, 0}});
  EXPECT_EQ(ids(keeper)[0], 1u);
  EXPECT_EQ(ages(keeper)[0], 3u);
}

TEST(TrackKeeper, IdentitiesAreNeverUsedAgain) {
  TrackKeeper keeper;
  std::set<std::uint64_t> seen;
  for (int round = 0; round < 3; ++round) {
    for (std::uint64_t k = 1; k < 10; ++k) {
      keeper.add(frame(k, 5));
      for (const std::uint64_t id : ids(keeper)) EXPECT_TRUE(seen.insert(id).second) << id;
    }
    keeper.reset();
    EXPECT_FALSE(keeper.newest());
    EXPECT_TRUE(keeper.tracks().empty());
  }
}

/// A bridge that is asked, notes what it was asked, and finds feature 0 in feature 0.
struct NotedBridge {
  struct Call {
    std::vector<std::uint32_t> free, lost;
    std::vector<FeatureLink> seen;
  };
  std::vector<Call> calls;

  TrackBridge bridge(std::vector<FeatureLink> links) {
    return [this, links](const GapTask& task) {
      calls.push_back({task.free, task.lost, task.seen});
      return links;
    };
  }
};

TEST(TrackKeeper, GapsUpToTheLimitAreBridged) {
  for (const std::size_t gap : {1u, 2u, 3u, 4u}) {
    for (const std::size_t max_gap : {0u, 1u, 3u}) {
      NotedBridge noted;
      TrackKeeper keeper(max_gap, noted.bridge({{0, 0, 0}}), 10);
      keeper.add(frame(1, 2, true));
      // Feature 1 is found all the time; feature 0 is missing in `gap` frames, which have no other features.
      std::uint64_t k = 2;
      std::uint32_t last = 1;
      for (std::size_t i = 0; i < gap; ++i, ++k) {
        keeper.add(frame(k, 1, true), k - 1, {{0, last, 0}});
        last = 0;
      }
      keeper.add(frame(k, 2, true), k - 1, {{1, 0, 0}});
      const bool bridged = gap <= max_gap;
      EXPECT_EQ(ids(keeper)[0] == 1, bridged) << gap << " " << max_gap;
      EXPECT_EQ(ages(keeper)[0], bridged ? 2u : 1u);  // frames in which it was not seen do not count
      EXPECT_EQ(keeper.counts().bridged, bridged ? 1u : 0u);
      EXPECT_EQ(keeper.counts().begun, bridged ? 0u : 1u);
      EXPECT_EQ(ages(keeper)[1], gap + 2);
      EXPECT_TRUE(std::isnan(keeper.tracks()[0].previous.x));
      if (!bridged) continue;
      ASSERT_FALSE(noted.calls.empty());
      const NotedBridge::Call& call = noted.calls.back();
      if (gap == max_gap) {
        EXPECT_EQ(call.free, (std::vector<std::uint32_t>{0}));
        EXPECT_EQ(call.lost, (std::vector<std::uint32_t>{0}));
        EXPECT_EQ(call.seen, (std::vector<FeatureLink>{{1, 1, 0}}));
      }
    }
  }
}

TEST(TrackKeeper, TheBridgeCannotBreakATrack) {
  // It links a feature that has a track, a track that goes on, and what does not exist.
  NotedBridge noted;
  TrackKeeper keeper(1, noted.bridge({{0, 1, 0}, {1, 0, 0}, {7, 1, 0}, {1, 9, 0}}));
  keeper.add(frame(1, 2, true));
  keeper.add(frame(2, 1, true), 1, {{0, 0, 0}});
  keeper.add(frame(3, 2, true), 2, {{0, 0, 0}});
  EXPECT_EQ(ids(keeper)[0], 1u);
  EXPECT_EQ(ages(keeper), (std::vector<std::uint32_t>{3, 1}));
  EXPECT_EQ(keeper.counts().bridged, 0u);
}

TEST(TrackKeeper, AFrameWithoutLinksIsBridgedToTheFrameBefore) {
  NotedBridge noted;
  TrackKeeper keeper(1, noted.bridge({{0, 0, 0}}));
  keeper.add(frame(1, 2, true));
  keeper.add(frame(2, 2, true));
  EXPECT_EQ(ids(keeper)[0], 1u);
  EXPECT_EQ(keeper.tracks()[0].previous, cv::Point2f(0, 1));
}

TEST(TrackKeeper, AFailingBridgeLosesNoFrame) {
  TrackKeeper keeper(1, [](const GapTask&) -> std::vector<FeatureLink> { throw std::runtime_error("no"); });
  keeper.add(frame(1, 2, true));
  EXPECT_EQ(errorOf([&] { keeper.add(frame(2, 2, true)); }), "no");
  EXPECT_EQ(keeper.newest(), 2u);
  EXPECT_EQ(ages(keeper), (std::vector<std::uint32_t>{1, 1}));
  keeper.setBridge({});
  keeper.add(frame(3, 2, true), 2, {{0, 0, 0}});
  EXPECT_EQ(ages(keeper), (std::vector<std::uint32_t>{2, 1}));
}

TEST(TrackKeeper, MemoryIsBounded) {
  TrackKeeper keeper(2, {}, 20);
  std::size_t most = 0;
  std::weak_ptr<const Features> old;
  for (std::uint64_t k = 1; k <= 100000; ++k) {
    TrackKeeper::Frame next = frame(k, 5, true);
    if (k == 500) old = next.features;
    if (k == 1) {
      keeper.add(std::move(next));
    } else {
      keeper.add(std::move(next), k - 1, {{0, 0, 0}, {1, 2, 0}});
    }
    most = std::max(most, keeper.remembered());
  }
  EXPECT_LE(most, 21u * 5);
  EXPECT_TRUE(old.expired());
  EXPECT_EQ(ids(keeper)[0], 1u);
  EXPECT_EQ(ages(keeper)[0], 100000u);
}

TEST(TrackKeeper, BadInputIsNamedAndChangesNothing) {
  TrackKeeper keeper;
  keeper.add(frame(5, 2));
  EXPECT_TRUE(mentions(errorOf([&] { keeper.add(frame(5, 2)); }), {"frame 5", "order", "reset()"}));
  EXPECT_TRUE(mentions(errorOf([&] { keeper.add(frame(6, 2), 4, {}); }), {"6", "frame 4", "not known"}));
  EXPECT_TRUE(mentions(errorOf([&] { keeper.add(frame(6, 2), 5, {{2, 0, 0}}); }), {"feature 2 of 2"}));
  EXPECT_TRUE(mentions(errorOf([&] { keeper.add(frame(6, 2), 5, {{0, 7, 0}}); }), {"feature 7 of 2"}));
  TrackKeeper::Frame unequal = frame(6, 2, true);
  unequal.points.pop_back();
  EXPECT_TRUE(mentions(errorOf([&] { keeper.add(unequal); }), {"1 points", "2 features"}));
  EXPECT_EQ(keeper.newest(), 5u);
  EXPECT_TRUE(mentions(errorOf([] { TrackKeeper(3, {}, 4); }), {"max_frames is 4", "5"}));
}

TEST(TrackKeeper, PositionsMayBeFilledInLater) {
  TrackKeeper keeper;
  TrackKeeper::Frame unknown = frame(1, 2);
  unknown.points[0] = {kNaN, kNaN};
  keeper.add(unknown);
  keeper.locate(1, {{3, 4}, {5, 6}});
  keeper.locate(9, {{7, 8}});
  keeper.add(frame(2, 2), 1, {{0, 0, 0}, {1, 1, 0}});
  EXPECT_EQ(keeper.tracks()[0].first.point, cv::Point2f(3, 4));
  EXPECT_EQ(keeper.tracks()[0].previous, cv::Point2f(3, 4));
  EXPECT_EQ(keeper.tracks()[1].previous, cv::Point2f(1, 1));  // what is known stays
}

TEST(TrackKeeper, LinksAndPointsOfMatches) {
  Correspondences matches;
  for (int i = 0; i < 3; ++i) matches.add({float(i), 1}, {float(10 * i), 2});
  EXPECT_TRUE(mentions(errorOf([&] { selectedLinks(matches, {1, 1, 1}); }), {"left_index", "0 elements"}));
  matches.left_index = {3, 0, 1};
  matches.right_index = {1, 0, 2};
  matches.distance = {7, 8, 9};
  const std::vector<FeatureLink> links = selectedLinks(matches, {1, 0, 1});
  EXPECT_EQ(links, (std::vector<FeatureLink>{{3, 1, 7}, {1, 2, 9}}));
  EXPECT_EQ(links[1].cost, 9);
  EXPECT_TRUE(mentions(errorOf([&] { selectedLinks(matches, {1}); }), {"mask", "1", "3"}));
  const std::vector<cv::Point2f> points = matchedPoints(matches, MatchSide::kLeft, 5);
  ASSERT_EQ(points.size(), 5u);
  EXPECT_EQ(points[3], cv::Point2f(0, 1));
  EXPECT_TRUE(std::isnan(points[2].x));
  EXPECT_EQ(matchedPoints(matches, MatchSide::kRight, 3)[2], cv::Point2f(20, 2));
  EXPECT_TRUE(mentions(errorOf([&] { matchedPoints(matches, MatchSide::kLeft, 3); }),
                       {"left feature 3", "3 features"}));
  EXPECT_TRUE(mentions(errorOf([&] { matchedPoints(matches, MatchSide::kLeft, 4000000000); }),
                       {"4000000000 features", "1000000"}));
  matches.distance.clear();
  matches.probability = {0.25F, 0.5F, 1};
  EXPECT_EQ(selectedLinks(matches, {1, 0, 0})[0].cost, 0.75F);
}

}  // namespace
}  // namespace corrsel::core
