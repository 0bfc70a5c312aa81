#include <gtest/gtest.h>

#include "corrsel/selectors/usac.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

Selection chosen(const Correspondences& matches, OptionMap options = {}, const std::string& spec = "usac") {
  options["model"] = "auto";
  return createSelector(spec, options)->select(matches);
}

TEST(ModelChoice, PlaneGetsAHomography) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const double ratio : {0.9, 0.5, 0.2}) {
      const Scene scene = homographyScene({800, ratio, 0.7, seed});
      const Selection s = chosen(scene.matches);
      EXPECT_EQ(s.model_kind, ModelKind::kHomography);
      EXPECT_EQ(s.mask, createSelector("usac:h")->select(scene.matches).mask);
      EXPECT_EQ(chosen(scene.matches, {}, "ransac").model_kind, ModelKind::kHomography);
    }
  }
}

TEST(ModelChoice, DepthGetsAFundamentalMatrix) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene = stereoScene({800, 0.6, 0.5, seed});
    const Selection s = chosen(scene.matches), f = createSelector("usac:f")->select(scene.matches);
    EXPECT_EQ(s.model_kind, ModelKind::kFundamental);
    EXPECT_EQ(s.mask, f.mask);
    EXPECT_EQ(s.status, Status::kOk);
    // Both searches count.
    EXPECT_GT(s.iterations, f.iterations);
    EXPECT_GT(quality(s.mask, scene.inlier).f, 93);
    EXPECT_EQ(chosen(scene.matches, {}, "ransac").model_kind, ModelKind::kFundamental);
  }
}

TEST(ModelChoice, OrderOfTheInputDoesNotMatter) {
  const Scene scene = stereoScene({500, 0.6, 0.5, 3});
  const std::vector<std::uint32_t> order = permutation(500, 4);
  const Selection a = chosen(scene.matches), b = chosen(scene.matches.subset(order));
  EXPECT_EQ(a.model, b.model);
  for (std::size_t i = 0; i < 500; ++i) EXPECT_EQ(a.mask[order[i]], b.mask[i]);
}

TEST(ModelChoice, FewMatchesAndNone) {
  for (const std::size_t n : {0, 3, 4, 5, 8, 12}) {
    SCOPED_TRACE(n);
    const Selection s = chosen(homographyScene({n, 1.0, 0.0, 3}).matches);
    EXPECT_EQ(s.mask.size(), n);
    EXPECT_EQ(s.status, n < 4 ? Status::kTooFew : n == 4 ? Status::kDegenerate : Status::kOk);
    EXPECT_EQ(s.n_selected, n > 4 ? n : 0);
  }
}

TEST(ModelChoice, BothSearchesShareTheTime) {
  const Scene scene = stereoScene({3000, 0.02, 0.5, 1});
  const TickingClock clock(1);
  const Selection s = chosen(scene.matches, {{"max_seconds", "30.5"}});
  EXPECT_EQ(s.status, Status::kTimeLimit);
  EXPECT_LE(clock.looks(), 40);
  EXPECT_GT(s.iterations, 0);
}

}  // namespace
}  // namespace corrsel::core
