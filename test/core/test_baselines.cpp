#include <gtest/gtest.h>

#include "baselines/baselines.h"
#include "corrsel/datasets/scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

MatchScene plane(std::size_t n, double inlier_ratio = 0.5) {
  return makeScene({MatchSceneKind::kPlane, n, inlier_ratio, 1});
}

Mask selected(const std::string& spec, const Correspondences& matches) {
  return createSelector(spec)->select(matches).mask;
}

std::size_t differing(const Mask& a, const Mask& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count + (a.size() == b.size() ? 0 : 1);
}

/// Repeats some matches and moves all to whole pixels, which makes many equal distances.
Correspondences withTiesAndDuplicates(const Correspondences& matches) {
  Correspondences result;
  result.left_size = matches.left_size;
  result.right_size = matches.right_size;
  const auto coarse = [](float x) { return 16 * std::round(x / 16); };
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const cv::Point2f left(coarse(matches.left_x[i]), coarse(matches.left_y[i]));
    const cv::Point2f right(coarse(matches.right_x[i]), coarse(matches.right_y[i]));
    for (std::size_t k = 0; k < (i % 7 == 0 ? 3 : 1); ++k) result.add(left, right);
  }
  return result;
}

TEST(Baselines, GmsSelectsTheSame) {
  for (const std::size_t n : {300U, 3000U}) {
    const auto scene = plane(n, 0.7);
    const Mask plain = baselines::gmsTextbook(scene.matches);
    EXPECT_GT(quality(plain, scene.inlier).f, n == 300 ? 50 : 97) << n;
    EXPECT_EQ(plain, selected("gms", scene.matches)) << n;
    EXPECT_EQ(baselines::gmsTextbook(scene.matches, true, true),
              selected("gms:rotation_scale", scene.matches));
  }
}

TEST(Baselines, LpmSelectsTheSame) {
  for (const std::size_t n : {5U, 300U}) {
    for (const bool ties : {false, true}) {
      const auto scene = plane(n);
      const Correspondences matches = ties ? withTiesAndDuplicates(scene.matches) : scene.matches;
      const Mask paper = baselines::lpmTextbook(matches, baselines::LpmVariant::kPaper);
      const Mask v2 = baselines::lpmTextbook(matches, baselines::LpmVariant::kV2);
      EXPECT_EQ(paper, selected("lpm:paper", matches)) << n << " " << ties;
      EXPECT_EQ(v2, selected("lpm:v2", matches)) << n << " " << ties;
      if (n < 300 || ties) continue;
      EXPECT_GT(quality(paper, scene.inlier).f, 90);
      EXPECT_GT(quality(v2, scene.inlier).f, 90);
    }
  }
}

TEST(Baselines, VfcVariantsAgree) {
  const auto scene = plane(300);
  const Mask dense = baselines::vfcDense(scene.matches);
  EXPECT_GT(quality(dense, scene.inlier).f, 98);
  EXPECT_LE(differing(dense, baselines::vfcSparse(scene.matches)), 3U);
  EXPECT_LE(differing(dense, selected("vfc", scene.matches)), 1U);
}

TEST(Baselines, StDecidesAlike) {
  const auto scene = plane(300);
  const Mask dense = baselines::stDense(scene.matches);
  EXPECT_GT(quality(dense, scene.inlier).f, 90);
  EXPECT_LE(differing(dense, selected("st", scene.matches)), 3U);
}

TEST(Baselines, GtmDecidesAlike) {
  const auto scene = plane(300);
  const Mask dense = baselines::gtmDense(scene.matches);
  EXPECT_GT(quality(dense, scene.inlier).f, 90);
  EXPECT_LE(differing(dense, selected("gtm", scene.matches)), 3U);
}

}  // namespace
}  // namespace corrsel::core
