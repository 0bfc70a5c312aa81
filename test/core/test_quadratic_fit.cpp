#include <gtest/gtest.h>

#include "features/parts/quadratic_fit.h"

namespace corrsel::core {
namespace {

TEST(QuadraticFit, FindsTheExtremumOfAQuadratic) {
  const double x0 = 0.3, y0 = -0.2, l0 = 0.4;
  const auto sample = [&](double level, double y, double x) {
    const double dx = x - x0, dy = y - y0, dl = level - l0;
    return 7 - 2 * dx * dx - 3 * dy * dy - 4 * dl * dl + dx * dy - 0.5 * dx * dl + 0.25 * dy * dl;
  };
  const QuadraticFit fit = fitQuadratic([&](int l, int y, int x) { return sample(l, y, x); });
  ASSERT_TRUE(fit.solved);
  EXPECT_NEAR(fit.offset[0], x0, 1e-12);
  EXPECT_NEAR(fit.offset[1], y0, 1e-12);
  EXPECT_NEAR(fit.offset[2], l0, 1e-12);
  EXPECT_NEAR(fit.reach(), l0, 1e-12);
  EXPECT_NEAR(fit.extremum(), 7, 1e-12);
  EXPECT_NEAR(fit.trace(), -10, 1e-12);
  EXPECT_NEAR(fit.determinant(), 23, 1e-12);
}

TEST(QuadraticFit, ReportsThatAPlaneHasNoExtremum) {
  EXPECT_FALSE(fitQuadratic([](int l, int y, int x) { return 1.0 * x + 2.0 * y + 3.0 * l; }).solved);
}

}  // namespace
}  // namespace corrsel::core
