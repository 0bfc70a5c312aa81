#include <gtest/gtest.h>

#include "base/text.h"
#include "corrsel/reference/icf.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Icf, FindsASmoothMotion) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Scene scene = homographyScene({1000, 0.7, 0.5, seed});
    // Bend the right image.
    for (float& y : scene.matches.right_y) y += 15 * std::sin(y / 100);
    const Selection s = IcfSelector().select(scene.matches);
    const Quality q = quality(s.mask, scene.inlier);
    EXPECT_GT(q.precision, 97);
    EXPECT_GT(q.recall, 97);
    EXPECT_EQ(s.iterations, 5);
    for (std::size_t i = 0; i < s.mask.size(); ++i) ASSERT_EQ(s.mask[i] == 1, s.score[i] > -5.0F);
  }
}

TEST(Icf, BothFunctionsMustAgree) {
  // Matches of one right point: the function to the right can be constant there, the one to the left cannot.
  Scene scene = homographyScene({300, 1.0, 0.3, 4});
  Random random(5);
  for (int i = 0; i < 40; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth - 1, kSceneHeight - 1);
    addMatch(scene, random, left, {400, 300}, false);
  }
  EXPECT_GT(quality(IcfSelector().select(scene.matches).mask, scene.inlier).precision, 97);
}

TEST(Icf, DoesNotDependOnUnitAndOrigin) {
  const Correspondences m = homographyScene({400, 0.6, 0.5, 5}).matches;
  const Selection expected = IcfSelector().select(m);
  Correspondences scaled = m;
  for (std::vector<float>* column : {&scaled.left_x, &scaled.left_y, &scaled.right_x, &scaled.right_y}) {
    for (float& value : *column) value = 4 * value + 64;
  }
  const Selection s =
      createSelector("icf", {{"epsilon", "8"}, {"first_threshold", "640"}, {"last_threshold", "20"}})
          ->select(scaled);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < m.size(); ++i) changed += s.mask[i] != expected.mask[i];
  EXPECT_LE(changed, 1u);
}

TEST(Icf, DecidesDegenerateInput) {
  const Scene scene = homographyScene({50, 1.0, 0.0, 6});
  const IcfSelector icf;
  const Selection few = icf.select(scene.matches.subset({0, 1, 2, 3}));
  EXPECT_EQ(few.status, Status::kTooFew);
  EXPECT_EQ(few.message, "4 matches, icf needs 5");
  Correspondences m = scene.matches;
  m.right_x.assign(50, 1);
  m.right_y.assign(50, 2);
  EXPECT_EQ(icf.select(m).status, Status::kDegenerate);
  // Identical images, a line, copies.
  m = scene.matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  EXPECT_EQ(icf.select(m).n_selected, 50u);
  for (std::size_t i = 0; i < 50; ++i) {
    m.left_y[i] = 2 * m.left_x[i];
    m.right_x[i] = m.left_x[i] + 10;
    m.right_y[i] = m.left_y[i] - 10;
  }
  EXPECT_EQ(icf.select(m).n_selected, 50u);
  std::vector<std::uint32_t> rows(100);
  for (std::uint32_t i = 0; i < 100; ++i) rows[i] = i % 50;
  EXPECT_EQ(icf.select(m.subset(rows)).n_selected, 100u);
  // Nothing agrees.
  const Selection none = createSelector("icf", {{"first_threshold", "0.1"}, {"last_threshold", "0.1"}})
                             ->select(homographyScene({60, 0.0, 0.0, 7}).matches);
  EXPECT_EQ(none.n_selected, 0u);
  EXPECT_EQ(none.message, "fewer than 5 matches agree after round 1");
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] {
                         createSelector("icf", {{"last_threshold", "170"}});
                       }),
                       {"icf", "last_threshold = 170", "first_threshold = 160"}));
}

TEST(Icf, ReachesItsMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("icf");
  EXPECT_GT(q.precision, 97);
  EXPECT_GT(q.f, 64);
  // A stiffer function and a stricter start lose inliers of the smaller structures.
  const Quality stiff = adelaideMeans("icf", {{"lambda", "0.1"}, {"first_threshold", "40"}});
  EXPECT_GT(q.f, stiff.f);
}

}  // namespace
}  // namespace corrsel::core
