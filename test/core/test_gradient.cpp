#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <vector>

#include "features/parts/gradient.h"

namespace corrsel::core {
namespace {

constexpr int kDirections = 36000;

/// The largest error of directionOf(), turns, over all directions and some lengths.
template <class Arctangent>
double largestError() {
  double largest = 0;
  for (const double length : {1e-3, 1.0, 400.0}) {
    for (int i = 0; i < kDirections; ++i) {
      const double turn = double(i) / kDirections;
      const float found = directionOf<Arctangent>(float(length * std::cos(2 * CV_PI * turn)),
                                                  float(length * std::sin(2 * CV_PI * turn)));
      EXPECT_TRUE(found >= 0 && found <= 1);
      const double difference = std::abs(found - turn);
      largest = std::max(largest, std::min(difference, 1 - difference));
    }
  }
  return largest;
}

TEST(Gradient, DirectionsAreAsExactAsDocumented) {
  EXPECT_LT(largestError<FineArctangent>(), 2e-6);
  EXPECT_LT(largestError<FastArctangent>(), 3e-5);
}

TEST(Gradient, PolarGradientsHaveTheGivenTurn) {
  std::vector<float> dx, dy;
  for (int i = 0; i < 3600; ++i) {
    dx.push_back(float(7 * std::cos(i * CV_PI / 1800)));
    dy.push_back(float(7 * std::sin(i * CV_PI / 1800)));
  }
  dx.push_back(0);
  dy.push_back(0);
  dx.push_back(5);
  dy.push_back(-1e-12F);
  std::vector<float> length(dx.size()), direction(dx.size());
  polarGradients(dx.data(), dy.data(), dx.size(), 8, length.data(), direction.data());
  for (std::size_t i = 0; i < dx.size(); ++i) {
    ASSERT_TRUE(direction[i] >= 0 && direction[i] < 8);
    if (i < 3600) {
      EXPECT_NEAR(length[i], 7, 1e-5);
      const double difference = std::abs(direction[i] - double(i) * 8 / 3600);
      EXPECT_LT(std::min(difference, 8 - difference), 8 * 2e-6) << i;
    }
  }
  EXPECT_EQ(length[3600], 0);
  EXPECT_EQ(direction[3600], 0);
}

TEST(Gradient, PatchGradientsAreCentralDifferences) {
  // x^2 + 10 y: dx = 4 x, dy = 20.
  std::vector<float> patch;
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) patch.push_back(float(x * x + 10 * y));
  }
  PatchGradients<5> gradients;
  gradients.compute(patch.data(), 4);
  ASSERT_EQ(gradients.kCount, 9u);
  for (int y = 1; y < 4; ++y) {
    for (int x = 1; x < 4; ++x) {
      const auto i = std::size_t((y - 1) * 3 + x - 1);
      EXPECT_EQ(gradients.dx[i], float(4 * x));
      EXPECT_EQ(gradients.dy[i], 20);
      EXPECT_NEAR(gradients.length[i], std::hypot(4 * x, 20), 1e-5);
      EXPECT_NEAR(gradients.direction[i], std::atan2(20, 4 * x) * 2 / CV_PI, 1e-5);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
