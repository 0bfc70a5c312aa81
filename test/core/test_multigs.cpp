#include <gtest/gtest.h>

#include "corrsel/reference/multigs.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Multigs, FindsHomographiesAndFundamentalMatrices) {
  for (const ModelKind model : {ModelKind::kHomography, ModelKind::kFundamental}) {
    const bool plane = model == ModelKind::kHomography;
    const Scene scene = plane ? homographyScene({300, 0.4, 0.5, 2}) : stereoScene({300, 0.6, 0.5, 2});
    ReferenceSearchOptions options;
    options.model = model;
    const Selection s = MultigsSelector(options).select(scene.matches);
    EXPECT_EQ(s.model_kind, model);
    const Quality q = quality(s.mask, scene.inlier);
    EXPECT_GT(q.precision, 90);
    EXPECT_GT(q.recall, 90);
    EXPECT_LE(s.iterations, 5000);
  }
}

TEST(Multigs, NeedsNoDescriptorDistances) {
  Scene scene = homographyScene({300, 0.4, 0.5, 4});
  const Selection with = MultigsSelector().select(scene.matches);
  scene.matches.distance.clear();
  scene.matches.second_distance.clear();
  EXPECT_EQ(MultigsSelector().select(scene.matches).mask, with.mask);
}

}  // namespace
}  // namespace corrsel::core
