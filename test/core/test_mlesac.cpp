#include <gtest/gtest.h>

#include "corrsel/reference/mlesac.h"
#include "corrsel/selectors/ransac.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Mlesac, FindsHomographiesAndFundamentalMatrices) {
  for (const ModelKind model : {ModelKind::kHomography, ModelKind::kFundamental}) {
    const bool plane = model == ModelKind::kHomography;
    const Scene scene = plane ? homographyScene({400, 0.5, 0.5, 3}) : stereoScene({400, 0.6, 0.5, 3});
    ReferenceSearchOptions options;
    options.model = model;
    options.threshold = plane ? 5 : 2;
    const Selection s = MlesacSelector(options).select(scene.matches);
    EXPECT_EQ(s.model_kind, model);
    const Quality q = quality(s.mask, scene.inlier);
    EXPECT_GT(q.precision, 90);
    EXPECT_GT(q.recall, 90);
  }
}

TEST(Mlesac, ComparesByLikelihoodAndNotByMsac) {
  // The hypotheses are those of ransac, so only the comparison can make a difference.
  int different = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene = homographyScene({300, 0.4, 2, seed});
    const Selection likelihood = MlesacSelector().select(scene.matches);
    const Selection msac = RansacSelector().select(scene.matches);
    EXPECT_GT(quality(likelihood.mask, scene.inlier).recall, 90);
    different += likelihood.model != msac.model ? 1 : 0;
  }
  EXPECT_GT(different, 0);
}

}  // namespace
}  // namespace corrsel::core
