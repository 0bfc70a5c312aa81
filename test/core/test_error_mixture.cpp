#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "reference/error_mixture.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

MixtureFit fitted(const std::vector<float>& squared, const ErrorMixture& mixture) {
  std::vector<double> densities;
  return fitMixture(squared.data(), squared.size(), mixture, densities);
}

TEST(FitMixture, GoldenNumbers) {
  std::vector<float> squared;
  for (int i = 0; i < 60; ++i) squared.push_back(static_cast<float>(std::pow(3.0 * i / 59, 2)));
  for (int i = 0; i < 40; ++i) squared.push_back(static_cast<float>(std::pow(5 + 195.0 * i / 39, 2)));
  const MixtureFit fit = fitted(squared, {1.5 / 1.96, 800, 1});
  EXPECT_NEAR(fit.right_share, 0.518189, 1e-6);
  EXPECT_NEAR(fit.cost, 517.650, 1e-3);
}

TEST(FitMixture, InfiniteErrorsAreOutliers) {
  std::vector<float> squared(50, 0.0F);
  squared.resize(100, std::numeric_limits<float>::infinity());
  const MixtureFit fit = fitted(squared, {1, 1e6, 2});
  EXPECT_NEAR(fit.right_share, 0.5, 0.01);
  EXPECT_TRUE(std::isfinite(fit.cost));
}

TEST(Mlesac, FindsWhatMsacFinds) {
  for (const char* const model : {"homography", "fundamental"}) {
    const bool plane = std::string(model) == "homography";
    const SceneOptions options{1000, 0.5, 0.5, 3};
    const Scene scene = plane ? homographyScene(options) : stereoScene(options);
    const auto selector = createSelector("mlesac", {{"model", model}, {"threshold", plane ? "5" : "1.5"}});
    const Selection found = selector->select(scene.matches);
    EXPECT_EQ(found.status, Status::kOk) << found.message;
    EXPECT_GT(quality(found.mask, scene.inlier).f, plane ? 99 : 90) << model;
  }
}

}  // namespace
}  // namespace corrsel::core
