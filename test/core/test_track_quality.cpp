// Length and correctness of tracks on generated images, with known truth. The numbers that it prints are
// those of docs/studies/tracking.md.

#include <gtest/gtest.h>

#include <cstdio>

#include "base/stopwatch.h"
#include "test_support.h"
#include "track_sequence.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr int kFrames = 30;
/// A track is wrong if it ever is further than this from where its first sight should be, px: the accuracy of
/// the features adds to it.
constexpr double kTolerance = 3;
/// A track that is further away than this follows another point of the scene, px.
constexpr double kElsewhere = 10;

struct Quality {
  std::size_t tracks = 0, wrong = 0, elsewhere = 0, bridged = 0, rows = 0;
  double median = 0, mean = 0, seconds = 0;
};

Quality follow(const std::string& features, std::size_t max_gap, std::uint64_t seed) {
  TrackSequence sequence(seed);
  ImageTracker tracker(features, {{"sift", {{"max_features", "1000"}}}, {"orb", {{"max_features", "1000"}}}},
                       max_gap);
  const Stopwatch watch;
  for (int k = 0; k < kFrames; ++k) tracker.add(sequence.image(k));
  Quality quality;
  quality.seconds = watch.seconds();
  quality.bridged = tracker.bridged();
  std::vector<double> lengths;
  for (const auto& [id, sights] : tracker.sights()) {
    lengths.push_back(double(sights.size()));
    quality.rows += sights.size();
    double worst = 0;
    for (const TrackSight& sight : sights) {
      worst = std::max(worst, sequence.error(int(sights[0].frame) - 1, sights[0].point, int(sight.frame) - 1,
                                             sight.point));
    }
    quality.wrong += worst > kTolerance ? 1 : 0;
    quality.elsewhere += worst > kElsewhere ? 1 : 0;
  }
  quality.tracks = lengths.size();
  quality.median = quantile(lengths, 0.5);
  quality.mean = double(quality.rows) / double(quality.tracks);
  return quality;
}

class TrackQuality : public ::testing::TestWithParam<std::string> {};

TEST_P(TrackQuality, BridgedTracksAreLongerAndNotWrong) {
  for (const std::uint64_t seed : {1u, 2u}) {
    Quality quality[2];
    for (const std::size_t max_gap : {0u, 2u}) {
      const Quality q = quality[max_gap / 2] = follow(GetParam(), max_gap, seed);
      const double percent = 100 / double(q.tracks);
      std::printf(
          "%s, seed %d, max_gap %zu: %zu tracks, length median %.0f, mean %.2f; %zu bridged; %.2f %% wrong, "
          "%.2f %% elsewhere; %.1f ms a frame\n",
          GetParam().c_str(), int(seed), max_gap, q.tracks, q.median, q.mean, q.bridged,
          percent * double(q.wrong), percent * double(q.elsewhere), 1e3 * q.seconds / kFrames);
      EXPECT_GE(q.tracks, 1000u);
      EXPECT_LE(percent * double(q.wrong), GetParam() == "orb+orb" ? 20 : 8);
      EXPECT_LE(percent * double(q.elsewhere), 2.0);
    }
    EXPECT_EQ(quality[0].bridged, 0u);
    EXPECT_GE(quality[1].bridged, 200u);
    EXPECT_GT(quality[1].mean, 1.1 * quality[0].mean);
  }
}

INSTANTIATE_TEST_SUITE_P(Features, TrackQuality, ::testing::Values("sift+sift", "orb+orb"),
                         [](const auto& info) { return info.param.substr(0, info.param.find('+')); });

}  // namespace
}  // namespace corrsel::core
