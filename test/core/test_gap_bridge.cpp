#include <gtest/gtest.h>

#include "corrsel/selectors/factory.h"
#include "corrsel/tracking/gap_bridge.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr std::uint32_t kFeatures = 60;

/// Feature i has the descriptor of point order[i]. The points lie in a plane that moves by `shift` px.
std::shared_ptr<Features> frame(const std::vector<std::uint32_t>& order, float shift) {
  auto features = std::make_shared<Features>();
  features->image_size = {640, 480};
  features->descriptors.create(int(order.size()), 16, CV_32F);
  for (std::size_t i = 0; i < order.size(); ++i) {
    Random random(order[i] + 1);
    const float x = float(random.uniform(50, 500)), y = float(random.uniform(50, 400));
    features->keypoints.emplace_back(x + shift, y, 5.0F);
    for (int k = 0; k < 16; ++k) {
      features->descriptors.at<float>(int(i), k) = float(random.uniform(0, 100));
    }
  }
  return features;
}

std::vector<std::uint32_t> upTo(std::uint32_t n) {
  std::vector<std::uint32_t> numbers(n);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

/// Feature i of the earlier frame is feature n - 1 - i of the newest one. The first 40 points are seen in
/// both, the others are lost and free.
struct Scene {
  std::vector<std::uint32_t> turned = upTo(kFeatures);
  std::vector<std::uint32_t> free, lost;
  std::vector<FeatureLink> seen;
  std::shared_ptr<Features> earlier = frame(upTo(kFeatures), 0), newest;

  explicit Scene(std::uint32_t n_seen = 40) {
    std::reverse(turned.begin(), turned.end());
    newest = frame(turned, 12);
    for (std::uint32_t i = 0; i < kFeatures; ++i) {
      if (i < n_seen) {
        seen.push_back({kFeatures - 1 - i, i, 0});
      } else {
        lost.push_back(i);
        free.push_back(kFeatures - 1 - i);
      }
    }
    std::sort(free.begin(), free.end());
  }

  std::vector<FeatureLink> links(const std::string& selector = "auto") const {
    return GapBridge(createSelector(selector))({*newest, *earlier, free, lost, seen});
  }
};

TEST(GapBridge, FindsLostFeaturesAgain) {
  const std::vector<FeatureLink> links = Scene().links();
  EXPECT_EQ(links.size(), 20u);
  for (const FeatureLink& link : links) {
    EXPECT_EQ(link.newest, kFeatures - 1 - link.earlier);
    EXPECT_GE(link.earlier, 40u);  // those that are seen already are no links
  }
}

TEST(GapBridge, WorksForAFrameOfWhichNothingIsKnown) { EXPECT_EQ(Scene(0).links().size(), kFeatures); }

TEST(GapBridge, TheSelectorDecides) {
  Scene scene;
  // A lost feature whose look-alike is elsewhere.
  scene.newest->keypoints[kFeatures - 1 - 50].pt += cv::Point2f(90, -70);
  const std::vector<FeatureLink> links = scene.links();
  EXPECT_EQ(links.size(), 19u);
  for (const FeatureLink& link : links) EXPECT_NE(link.earlier, 50u);
  EXPECT_EQ(scene.links("keep_all").size(), 20u);
}

TEST(GapBridge, NoLinksWithoutAnAnswer) {
  const Scene scene;
  EXPECT_TRUE(scene.links("pose").empty());  // the frames have no cameras
  scene.newest->descriptors.release();
  EXPECT_TRUE(scene.links().empty());
  EXPECT_TRUE(mentions(errorOf([] { GapBridge(nullptr); }), {"selector is null"}));
}

TEST(GapBridge, ContinuesATrackInAKeeper) {
  const std::shared_ptr<const Selector> selector = createSelector("auto");
  TrackKeeper keeper(1, GapBridge(selector));
  const auto add = [&](std::uint64_t id, const std::shared_ptr<Features>& features) {
    TrackKeeper::Frame next{id, {}, features};
    for (const cv::KeyPoint& keypoint : features->keypoints) next.points.push_back(keypoint.pt);
    std::vector<FeatureLink> links;
    const std::uint32_t n = std::min<std::uint32_t>(40, std::uint32_t(next.points.size()));
    for (std::uint32_t i = 0; i < n; ++i) links.push_back({i, i, 0});
    if (keeper.newest()) {
      keeper.add(next, id - 1, links);
    } else {
      keeper.add(next);
    }
  };
  add(1, frame(upTo(kFeatures), 0));
  add(2, frame(upTo(40), 5));  // 20 are missing
  EXPECT_EQ(keeper.counts().lost, 20u);
  add(3, frame(upTo(kFeatures), 10));
  EXPECT_EQ(keeper.counts().bridged, 20u);
  for (std::uint32_t i = 0; i < kFeatures; ++i) {
    EXPECT_EQ(keeper.tracks()[i].id, i + 1u);
    EXPECT_EQ(keeper.tracks()[i].age, i < 40 ? 3u : 2u);
  }
}

}  // namespace
}  // namespace corrsel::core
