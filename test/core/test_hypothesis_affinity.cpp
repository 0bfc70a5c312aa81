#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "geometry/residual.h"
#include "reference/hypothesis_affinity.h"
#include "search/homography_model.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Two planes with 30 % of the matches each, side by side in the left image.
struct TwoPlanes {
  Correspondences matches;
  std::vector<int> plane;  // 2 = wrong
};

TwoPlanes twoPlanes() {
  Random random(1);
  TwoPlanes scene;
  for (int i = 0; i < 300; ++i) {
    const int of = i % 10 < 3 ? 0 : i % 10 < 6 ? 1 : 2;
    const cv::Point2d left = uniformPoint(random, 320, 480) + cv::Point2d(of == 1 ? 320 : 0, 0);
    const cv::Point2d wrong = uniformPoint(random, 640, 480);
    scene.matches.add(left, of == 2   ? wrong
                            : of == 0 ? left + cv::Point2d(20, 5)
                                      : 0.8 * left + cv::Point2d(60, 40));
    scene.plane.push_back(of);
  }
  return scene;
}

/// Draws as the search does, and counts the samples whose members are all of one plane among the last draws.
/// @param affinity  nullptr = uniform samples
int countPure(HypothesisAffinity* affinity, const TwoPlanes& scene, int hypotheses, int draws) {
  Random random(1);
  const NormalizedMatches matches = normalizeMatches(scene.matches);
  const HomographyModel homography(Residual::kTransfer);
  int pure = 0;
  for (int draw = 0, tried = 0; draw < draws;) {
    std::uint32_t s[4];
    if (affinity != nullptr) {
      affinity->draw(random, 4, s);
    } else {
      random.sample(300, 4, s);
    }
    if (tried >= hypotheses) {
      ++draw;
      const int plane = scene.plane[s[0]];
      pure +=
          plane < 2 && scene.plane[s[1]] == plane && scene.plane[s[2]] == plane && scene.plane[s[3]] == plane
              ? 1
              : 0;
      continue;
    }
    cv::Matx33d model;
    if (!homography.isValidSample(matches, s) || homography.solve(matches, s, &model) == 0) continue;
    ++tried;
    if (affinity == nullptr) continue;
    modelErrors(Residual::kTransfer, model, matches, 0, matches.size(), affinity->next());
    affinity->add();
  }
  return pure;
}

TEST(MultiGs, SamplesAreMoreOftenPure) {
  const TwoPlanes scene = twoPlanes();
  constexpr int kHypotheses = 500, kDraws = 4000;
  HypothesisAffinity affinity;
  affinity.start(300);
  const int pure = countPure(&affinity, scene, kHypotheses, kDraws);
  EXPECT_GT(pure, 5 * countPure(nullptr, scene, kHypotheses, kDraws));
}

TEST(MultiGs, AffinityIsTheNumberOfSharedBestHypotheses) {
  constexpr std::size_t kHypotheses = HypothesisAffinity::kBlock;
  HypothesisAffinity affinity;
  affinity.start(4);
  for (std::size_t h = 0; h < kHypotheses; ++h) {
    const auto error = static_cast<float>(h);
    float* const errors = affinity.next();
    errors[0] = error;                                   // prefers hypotheses 0 to 5
    errors[1] = std::abs(error - 5);                     // 5, 4, 6, 3, 7, 2
    errors[2] = std::numeric_limits<float>::infinity();  // equal errors: the first six
    errors[3] = -error;                                  // the last six
    affinity.add();
  }
  EXPECT_EQ(affinity.affinity(0, 0), 6u);
  EXPECT_EQ(affinity.affinity(0, 1), 4u);
  EXPECT_EQ(affinity.affinity(0, 2), 6u);
  EXPECT_EQ(affinity.affinity(0, 3), 0u);
  EXPECT_EQ(affinity.affinity(1, 3), 0u);
  affinity.start(4);
  EXPECT_EQ(affinity.affinity(0, 0), 0u);
}

TEST(MultiGs, SamplesAreDistinctAlsoWhereNothingIsAlike) {
  constexpr std::size_t kMatches = 10;
  HypothesisAffinity affinity;
  affinity.start(kMatches);
  Random random(1);
  std::vector<int> counts(kMatches, 0);
  for (std::size_t h = 0; h < HypothesisAffinity::kBlock * HypothesisAffinity::kBlocks; ++h) {
    // Each match likes six hypotheses of its own.
    for (std::size_t i = 0; i < kMatches; ++i)
      affinity.next()[i] = h % HypothesisAffinity::kBlock / 6 == i ? 0.0F : 1.0F;
    affinity.add();
  }
  for (int draw = 0; draw < 5000; ++draw) {
    std::uint32_t sample[7];
    affinity.draw(random, 7, sample);
    EXPECT_EQ(std::set<std::uint32_t>(sample, sample + 7).size(), 7u);
    for (const std::uint32_t k : sample) ++counts[k];
  }
  for (const int count : counts) EXPECT_NEAR(count, 3500, 200);
}

TEST(MultiGs, FindsModels) {
  const Scene scene = homographyScene({500, 0.4, 0.5, 3});
  const Selection found = createSelector("multigs")->select(scene.matches);
  EXPECT_EQ(found.status, Status::kOk) << found.message;
  EXPECT_GT(quality(found.mask, scene.inlier).f, 99);
  EXPECT_LE(found.iterations, 5000);
}

TEST(MultiGs, LooksAtTheClockBeforeEverySample) {
  const Scene scene = homographyScene({1000, 0, 0.5, 5});
  const TickingClock clock(1);
  const Selection found = createSelector("multigs", {{"max_seconds", "20.5"}})->select(scene.matches);
  EXPECT_EQ(found.status, Status::kTimeLimit) << found.message;
  EXPECT_LE(found.iterations, 20);
}

}  // namespace
}  // namespace corrsel::core
