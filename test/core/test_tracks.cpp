#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/text.h"
#include "corrsel/database/tracks.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

VerifiedPair verified(std::uint32_t first, std::uint32_t second, double confidence,
                      const std::vector<KeypointPair>& inliers) {
  VerifiedPair pair;
  pair.pair = {first, second};
  pair.confidence = confidence;
  pair.geometry.config = TwoViewConfig::kUncalibrated;
  pair.geometry.fundamental = cv::Matx33d::eye();
  pair.geometry.inliers = inliers;
  return pair;
}

/// A store in memory.
class MemoryStore : public PairStore {
 public:
  std::vector<StoredImage> list;
  std::map<std::uint32_t, StoredKeypoints> points;
  std::map<ImagePairKey, VerifiedPair> rows;
  std::set<std::string> configurations;

  /// @param images  the largest number of an image; all have as many keypoints
  MemoryStore(std::uint32_t images, std::uint32_t keypoints) {
    for (std::uint32_t image = 0; image <= images; ++image) {
      list.push_back({image, "image " + std::to_string(image) + ", left.jpg", {640, 480}, {}, false});
      for (std::uint32_t k = 0; k < keypoints; ++k)
        points[image].positions.emplace_back(float(image) + 0.1F, float(k) * 100.25F);
    }
  }

  const std::vector<StoredImage>& images() const override { return list; }
  std::vector<ImagePairKey> pairs() const override {
    std::vector<ImagePairKey> keys;
    for (const auto& [key, row] : rows) keys.push_back(key);
    return keys;
  }
  StoredKeypoints keypoints(std::uint32_t image) const override { return points.at(image); }
  StoredMatches matches(const ImagePairKey& pair) const override {
    return {rows.at(pair).geometry.inliers, {}};
  }
  std::vector<ImagePairKey> verifiedPairs(const std::string&) const override { return pairs(); }
  VerifiedPair verified(const ImagePairKey& pair) const override { return rows.at(pair); }
  void write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) override {
    for (const VerifiedPair& pair : pairs) rows[pair.pair] = pair;
    configurations.insert(configuration);
  }
};

using Track = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

std::vector<Track> listed(const Tracks& tracks) {
  std::vector<Track> result;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    result.emplace_back();
    for (std::size_t i = tracks.begin[t]; i < tracks.begin[t + 1]; ++i)
      result.back().emplace_back(tracks.observations[i].image, tracks.observations[i].keypoint);
  }
  return result;
}

TEST(Tracks, AreTheConnectedSetsOfKeypoints) {
  const Tracks tracks = buildTracks({verified(1, 2, 50, {{7, 3}, {0, 0}}), verified(2, 5, 40, {{3, 9}}),
                                     verified(1, 5, 30, {{2, 1}}), verified(1, 7, 30, {})});
  const std::vector<Track> expected = {{{1, 0}, {2, 0}}, {{1, 2}, {5, 1}}, {{1, 7}, {2, 3}, {5, 9}}};
  EXPECT_EQ(listed(tracks), expected);
  EXPECT_EQ(tracks.matches, 4u);
  EXPECT_EQ(tracks.cut, 0u);
  EXPECT_EQ(listed(buildTracks({verified(1, 2, 50, {{7, 3}, {0, 0}}), verified(2, 5, 40, {{3, 9}})}, 3)),
            (std::vector<Track>{{{1, 7}, {2, 3}, {5, 9}}}));
  EXPECT_EQ(buildTracks(std::vector<VerifiedPair>()).size(), 0u);
}

TEST(Tracks, AConflictIsCutWhereTheConfidenceIsLeast) {
  // 1:0 - 2:0 - 3:0 - 1:1 would put two keypoints of image 1 into one track.
  const auto cutAt = [](double a, double b, double c) {
    return listed(
        buildTracks({verified(1, 2, a, {{0, 0}}), verified(2, 3, b, {{0, 0}}), verified(1, 3, c, {{1, 0}})}));
  };
  const std::vector<Track> last = {{{1, 0}, {2, 0}, {3, 0}}}, first = {{{1, 1}, {2, 0}, {3, 0}}},
                           middle = {{{1, 0}, {2, 0}}, {{1, 1}, {3, 0}}};
  EXPECT_EQ(cutAt(9, 8, 7), last);
  EXPECT_EQ(cutAt(7, 8, 9), first);
  EXPECT_EQ(cutAt(9, 7, 8), middle);
  // The same confidence: in the order of the pairs (1, 2), (1, 3), (2, 3).
  EXPECT_EQ(cutAt(8, 8, 8), middle);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(cutAt(1, 0, unknown), last);
}

TEST(Tracks, LeaveOutWatermarksAndFaultyPairs) {
  VerifiedPair watermark = verified(1, 2, 50, {{0, 0}}), faulty = verified(1, 3, 50, {{0, 0}});
  watermark.geometry.config = TwoViewConfig::kWatermark;
  faulty.faulty = true;
  const Tracks tracks = buildTracks({watermark, faulty, verified(2, 3, 9, {{4, 4}})});
  EXPECT_EQ(listed(tracks), (std::vector<Track>{{{2, 4}, {3, 4}}}));
  EXPECT_EQ(tracks.matches, 1u);
}

/// Points seen by all images, whose keypoints have numbers of their own, and of each pair a share of wrong
/// matches.
struct TrackScene {
  std::vector<std::vector<std::uint32_t>> point;  // by image and keypoint
  std::vector<VerifiedPair> pairs;
};

TrackScene makeTrackScene(std::uint32_t images, std::uint32_t points, double wrong, std::uint64_t seed) {
  TrackScene scene;
  std::vector<std::vector<std::uint32_t>> keypoint(images);
  scene.point.resize(images);
  for (std::uint32_t i = 0; i < images; ++i) {
    keypoint[i] = permutation(points, seed * 100 + i);
    scene.point[i].resize(points);
    for (std::uint32_t p = 0; p < points; ++p) scene.point[i][keypoint[i][p]] = p;
  }
  Random random(seed);
  for (std::uint32_t a = 0; a < images; ++a) {
    for (std::uint32_t b = a + 1; b < images; ++b) {
      std::vector<KeypointPair> rows;
      std::vector<std::uint32_t> to = permutation(points, seed * 1000 + a * images + b);
      for (std::uint32_t p = 0; p < points; ++p) {
        if (random.uniform() < 0.4) continue;
        const bool is_wrong = random.uniform() < wrong;
        rows.push_back({keypoint[a][p], keypoint[b][is_wrong ? to[p] : p]});
      }
      scene.pairs.push_back(verified(a, b, 100 - 10.0 * (b - a), rows));
    }
  }
  return scene;
}

TEST(Tracks, NeverHoldTwoKeypointsOfOneImage) {
  const TrackScene scene = makeTrackScene(8, 200, 0.03, 1);
  const Tracks tracks = buildTracks(scene.pairs);
  EXPECT_GT(tracks.cut, 20u);
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  std::size_t pure = 0, of_all = 0;
  for (const Track& track : listed(tracks)) {
    ASSERT_GE(track.size(), 2u);
    std::set<std::uint32_t> points;
    for (std::size_t i = 0; i < track.size(); ++i) {
      ASSERT_TRUE(seen.insert(track[i]).second);
      if (i > 0) {
        ASSERT_LT(track[i - 1].first, track[i].first);
      }
      points.insert(scene.point[track[i].first][track[i].second]);
    }
    pure += points.size() == 1 ? 1 : 0;
    of_all += track.size() == 8 && points.size() == 1 ? 1 : 0;
  }
  // Without the cuts, nearly all keypoints are in one component.
  EXPECT_GT(double(pure), 0.8 * double(tracks.size()));
  EXPECT_GT(of_all, 130u);
}

TEST(Tracks, DoNotDependOnTheOrderOfTheInput) {
  TrackScene scene = makeTrackScene(6, 100, 0.05, 2);
  for (VerifiedPair& pair : scene.pairs) pair.confidence = 20;
  const std::vector<Track> expected = listed(buildTracks(scene.pairs));
  for (VerifiedPair& pair : scene.pairs)
    pair.geometry.inliers = reordered(pair.geometry.inliers, permutation(pair.geometry.inliers.size(), 5));
  const auto order = permutation(scene.pairs.size(), 3);
  EXPECT_EQ(listed(buildTracks(reordered(scene.pairs, order))), expected);
}

TEST(Tracks, OfAStoreAreThoseOfItsPairs) {
  const TrackScene scene = makeTrackScene(5, 50, 0.02, 3);
  MemoryStore store(5, 50);
  store.write(scene.pairs, "");
  const Tracks tracks = buildTracks(store, store.pairs()), direct = buildTracks(scene.pairs);
  EXPECT_EQ(listed(tracks), listed(direct));
  EXPECT_EQ(tracks.cut, direct.cut);
}

TEST(Tracks, HaveStatistics) {
  const TrackStatistics statistics =
      trackStatistics(buildTracks({verified(1, 2, 50, {{7, 3}, {0, 0}}), verified(2, 5, 40, {{3, 9}}),
                                   verified(1, 5, 30, {{0, 9}, {6, 6}})}));
  EXPECT_EQ(statistics.tracks, 3u);
  EXPECT_EQ(statistics.observations, 7u);
  EXPECT_EQ(statistics.matches, 5u);
  EXPECT_EQ(statistics.cut, 1u);
  EXPECT_DOUBLE_EQ(statistics.mean_length, 7.0 / 3);
  EXPECT_EQ(statistics.lengths, (std::vector<std::size_t>{0, 0, 2, 1}));
  EXPECT_EQ(statistics.per_image,
            (std::vector<std::pair<std::uint32_t, std::size_t>>{{1, 3}, {2, 2}, {5, 2}}));
  const TrackStatistics none = trackStatistics(Tracks());
  EXPECT_EQ(none.tracks, 0u);
  EXPECT_TRUE(std::isnan(none.mean_length));
}

TEST(Tracks, AreWrittenAsCsv) {
  const MemoryStore store(3, 10);
  const std::string path = ::testing::TempDir() + "/tracks.csv";
  writeTracks(path, buildTracks({verified(1, 3, 50, {{7, 3}, {0, 0}})}), store);
  EXPECT_EQ(readTextFile(path),
            "track,image,name,keypoint,x,y\n"
            "0,1,\"image 1, left.jpg\",0,1.1,0\n"
            "0,3,\"image 3, left.jpg\",0,3.1,0\n"
            "1,1,\"image 1, left.jpg\",7,1.1,701.75\n"
            "1,3,\"image 3, left.jpg\",3,3.1,300.75\n");
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  std::filesystem::remove(path);
}

TEST(Tracks, OnlyTheirMatchesRemainInTheStore) {
  const TrackScene scene = makeTrackScene(6, 80, 0.1, 4);
  MemoryStore store(6, 80);
  store.write(scene.pairs, "auto");
  // A pair whose only match is cut.
  const Tracks before = buildTracks(scene.pairs);
  writeTrackMatches(store, before, store.pairs(), "auto");
  EXPECT_EQ(store.configurations, (std::set<std::string>{"auto", trackConfiguration("auto")}));
  EXPECT_NE(trackConfiguration("auto"), "auto");
  std::size_t matches = 0;
  for (const auto& [key, pair] : store.rows) {
    matches += pair.geometry.inliers.size();
    EXPECT_TRUE(pair.geometry.fundamental);
  }
  EXPECT_EQ(matches + before.cut, before.matches);
  // What is left makes the same tracks without any conflict.
  const Tracks after = buildTracks(store, store.pairs());
  EXPECT_EQ(listed(after), listed(before));
  EXPECT_EQ(after.cut, 0u);
}

TEST(Tracks, APairWithoutMatchesInTracksBecomesUndefined) {
  MemoryStore store(3, 10);
  store.write({verified(1, 2, 9, {{0, 0}}), verified(1, 3, 8, {{1, 0}}), verified(2, 3, 7, {{0, 0}})}, "");
  const auto pairs = store.pairs();
  writeTrackMatches(store, buildTracks(store, pairs), pairs, "");
  const TwoViewGeometry& geometry = store.rows.at({2, 3}).geometry;
  EXPECT_EQ(geometry.config, TwoViewConfig::kUndefined);
  EXPECT_TRUE(geometry.inliers.empty());
  EXPECT_FALSE(geometry.fundamental);
  EXPECT_EQ(store.rows.at({1, 3}).geometry.config, TwoViewConfig::kUncalibrated);
}

TEST(Tracks, WrongInputIsNamed) {
  const VerifiedPair pair = verified(3, 8, 50, {{7, 3}});
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] {
                         buildTracks({pair, pair});
                       }),
                       {"(3, 8)", "twice", "once"}));
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { buildTracks({pair}, 1); }),
                       {"min_length", "1", "at least 2"}));
  MemoryStore store(8, 5);
  for (const std::uint32_t beyond : {5U, 0xFFFFFFFFU}) {
    store.write({verified(3, 8, 50, {{1, 2}, {3, beyond}})}, "");
    EXPECT_TRUE(mentions(errorOf<StoreError>([&] { buildTracks(store, store.pairs()); }),
                         {"keypoint " + std::to_string(beyond), "image 8", "has 5", "again"}));
  }
  const std::string path = ::testing::TempDir() + "/tracks.csv";
  EXPECT_TRUE(mentions(errorOf<StoreError>([&] { writeTracks(path, buildTracks({pair}), store); }),
                       {"keypoint 7", "image 3", "5"}));
  const std::string nowhere = ::testing::TempDir() + "/no such folder/tracks.csv";
  EXPECT_TRUE(mentions(errorOf<StoreError>([&] {
                         writeTracks(nowhere, buildTracks({verified(1, 2, 9, {{0, 0}})}), store);
                       }),
                       {"no such folder", "written"}));
}

}  // namespace
}  // namespace corrsel::core
