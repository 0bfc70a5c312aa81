#include <gtest/gtest.h>

#include "search/affine_growing.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

const cv::Matx33d kMap(1.1, -0.2, 40, 0.25, 0.95, -30, 0, 0, 1);
constexpr double kDiagonal = 1000;

/// Matches of kMap on a lattice with the given spacing, with the first one at (400, 300), and outliers.
Correspondences lattice(double spacing, int side, int wrong) {
  Correspondences m;
  m.add({400, 300}, projected(kMap, 400, 300));
  for (int row = -side; row <= side; ++row) {
    for (int column = -side; column <= side; ++column) {
      if (row == 0 && column == 0) continue;
      const double x = 400 + spacing * column, y = 300 + spacing * row;
      m.add({static_cast<float>(x), static_cast<float>(y)}, projected(kMap, x, y));
    }
  }
  Random random(1);
  for (int i = 0; i < wrong; ++i) {
    const cv::Point2d left = uniformPoint(random, 800, 600);
    m.add(left, uniformPoint(random, 800, 600));
  }
  return m;
}

void expectNearTruth(const cv::Matx33d& map, double tolerance) {
  for (const cv::Point2d& p : {cv::Point2d(0, 0), cv::Point2d(800, 0), cv::Point2d(400, 600)})
    EXPECT_LT(cv::norm(projected(map, p.x, p.y) - projected(kMap, p.x, p.y)), tolerance);
}

TEST(AffineGrowing, MakesARoughMapPrecise) {
  const Correspondences m = lattice(20, 8, 100);
  const std::vector<float> weights(m.size(), 1.0F);
  AffineGrowing growing;
  growing.assign(m, weights, kDiagonal);
  ASSERT_TRUE(growing.grow(0, {1.2F, -0.1F, 0.15F, 1.0F}));
  expectNearTruth(growing.map(), 3);
  EXPECT_GE(growing.supporters().size(), 17U * 17U);
}

TEST(AffineGrowing, LooksFartherWhereNothingIsNear) {
  // The nearest supporters are 150 px away, beyond the first radius of 62.5 px.
  const Correspondences m = lattice(150, 1, 0);
  const std::vector<float> weights(m.size(), 1.0F);
  AffineGrowing growing;
  growing.assign(m, weights, kDiagonal);
  ASSERT_TRUE(growing.grow(0, {1.15F, -0.15F, 0.2F, 1.0F}));
  expectNearTruth(growing.map(), 3);
}

TEST(AffineGrowing, FindsNothingAmongOutliers) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Correspondences m;
    for (int i = 0; i < 30; ++i) {
      const cv::Point2d left = uniformPoint(random, 800, 600);
      m.add(left, uniformPoint(random, 800, 600));
    }
    const std::vector<float> weights(m.size(), 1.0F);
    AffineGrowing growing;
    growing.assign(m, weights, kDiagonal);
    found += growing.grow(0, {1, 0, 0, 1}) ? 1 : 0;
  }
  EXPECT_LE(found, 2);
}

TEST(AffineGrowing, MatchesWithoutWeightHaveNoInfluence) {
  Correspondences m = lattice(20, 8, 0);
  const std::size_t right = m.size();
  for (int i = 0; i < 30; ++i) {
    const double x = 380 + i, y = 290;
    m.add({static_cast<float>(x), static_cast<float>(y)}, projected(kMap, x, y) + cv::Point2d(3, -3));
  }
  std::vector<float> weights(m.size(), 1.0F);
  std::fill(weights.begin() + static_cast<std::ptrdiff_t>(right), weights.end(), 0.0F);
  AffineGrowing growing;
  growing.assign(m, weights, kDiagonal);
  ASSERT_TRUE(growing.grow(0, {1.1F, -0.2F, 0.25F, 0.95F}));
  expectNearTruth(growing.map(), 0.5);
}

}  // namespace
}  // namespace corrsel::core
