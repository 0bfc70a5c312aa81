#include <gtest/gtest.h>

#include "corrsel/reference/pnapsac.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Pnapsac, FindsHomographiesAndFundamentalMatrices) {
  for (const ModelKind model : {ModelKind::kHomography, ModelKind::kFundamental}) {
    const bool plane = model == ModelKind::kHomography;
    const Scene scene = plane ? homographyScene({500, 0.2, 0.5, 5}) : stereoScene({500, 0.5, 0.5, 5});
    ReferenceSearchOptions options;
    options.model = model;
    const Selection s = PnapsacSelector(options).select(scene.matches);
    EXPECT_EQ(s.model_kind, model);
    const Quality q = quality(s.mask, scene.inlier);
    EXPECT_GT(q.precision, 90);
    EXPECT_GT(q.recall, 90);
    EXPECT_TRUE(s.message.empty()) << s.message;
  }
}

TEST(Pnapsac, ReportsThatSamplesAreUniformWithoutDistances) {
  Scene scene = homographyScene({500, 0.5, 0.5, 6});
  scene.matches.distance.clear();
  scene.matches.second_distance.clear();
  const Selection s = PnapsacSelector().select(scene.matches);
  EXPECT_GT(quality(s.mask, scene.inlier).recall, 90);
  EXPECT_NE(s.message.find("descriptor distances"), std::string::npos) << s.message;
}

}  // namespace
}  // namespace corrsel::core
