#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "geometry/fundamental.h"
#include "geometry/homography.h"
#include "geometry/residual.h"
#include "posterior/noise_scale.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr ResidualKind kHomographyKind = {2, 8, 10, 0}, kFundamentalKind = {1, 7, 10, 0};
constexpr int kRuns = 60;

/// Squared residuals of matches in an image of 640 x 480 px: inliers with Gaussian noise, and outliers that
/// are uniform in the image or on a line of 640 px.
std::vector<double> residuals(int dimensions, std::size_t n, double ratio, double sigma, Random& random) {
  std::vector<double> squared;
  for (std::size_t i = 0; i < n; ++i) {
    if (i < std::size_t(std::lround(ratio * double(n)))) {
      const double x = sigma * random.normal(), y = sigma * random.normal();
      squared.push_back(dimensions == 2 ? x * x + y * y : x * x);
    } else {
      const double x = random.uniform(-320, 320), y = random.uniform(-240, 240);
      squared.push_back(dimensions == 2 ? x * x + y * y : x * x);
    }
  }
  return squared;
}

/// Mean of estimates over many drawings.
double meanSigma(const ResidualKind& kind, std::size_t n, double ratio, double sigma) {
  Random random(n + std::uint64_t(1000 * ratio));
  double sum = 0;
  for (int run = 0; run < kRuns; ++run)
    sum += estimateNoiseScale(residuals(kind.dimensions, n, ratio, sigma, random), kind).sigma;
  return sum / kRuns;
}

TEST(NoiseScale, IsFoundAmongOutliers) {
  for (ResidualKind kind : {kHomographyKind, kFundamentalKind}) {
    kind.parameters = 0;
    for (const double sigma : {0.3, 0.6, 1.0, 2.0}) {
      for (const double ratio : {0.2, 0.5, 0.9}) {
        for (const std::size_t n : {100, 500, 2000}) {
          EXPECT_NEAR(meanSigma(kind, n, ratio, sigma), sigma, 0.05 * sigma)
              << kind.dimensions << " dimensions, " << n << " matches, share " << ratio;
        }
      }
    }
  }
}

TEST(NoiseScale, IsNotMadeSmallerByTheCut) {
  for (ResidualKind kind : {kHomographyKind, kFundamentalKind}) {
    kind.parameters = 0;
    kind.cut = 5.5;  // 2.2 sigma
    Random random(0);
    const double found = estimateNoiseScale(residuals(kind.dimensions, 100000, 1, 2.5, random), kind).sigma;
    EXPECT_NEAR(found, 2.5, 0.1) << kind.dimensions << " dimensions";
  }
}

TEST(NoiseScale, IsNotMadeSmallerByTheFit) {
  double corrected[2] = {}, plain[2] = {};
  for (int run = 0; run < kRuns; ++run) {
    for (const bool homography : {true, false}) {
      const Scene scene = homography ? homographyScene({40, 1, 1.0, std::uint64_t(run)})
                                     : stereoScene({40, 1, 1.0, std::uint64_t(run)});
      const NormalizedMatches matches = normalizeMatches(scene.matches);
      const float all = std::numeric_limits<float>::max();
      cv::Matx33d model = homography ? matches.homographyFromPixels(scene.model)
                                     : matches.right.inv().t() * scene.model * matches.left.inv();
      model *= 1 / cv::norm(model);
      for (int step = 0; step < 5; ++step) {
        ASSERT_TRUE(homography ? refineHomography(matches, Residual::kTransfer, all, model)
                               : refineFundamental(matches, all, model));
      }
      model = homography ? matches.homographyToPixels(model) : matches.fundamentalToPixels(model);
      std::vector<double> errors(scene.matches.size());
      pixelErrors(homography ? Residual::kTransfer : Residual::kSampson, model, scene.matches, errors.data());
      ResidualKind kind = homography ? kHomographyKind : kFundamentalKind;
      corrected[homography] += estimateNoiseScale(errors, kind).sigma / kRuns;
      kind.parameters = 0;
      plain[homography] += estimateNoiseScale(errors, kind).sigma / kRuns;
    }
  }
  EXPECT_NEAR(corrected[1], 1, 0.04);
  EXPECT_LT(plain[1], 0.95);
  EXPECT_NEAR(corrected[0] / plain[0], std::sqrt(40.0 / 33), 0.03);
}

TEST(NoiseScale, AKnownBackgroundHelpsWhereItIsStrong) {
  ResidualKind kind = kFundamentalKind;
  kind.parameters = 0;
  double with = 0, without = 0;
  for (int run = 0; run < kRuns; ++run) {
    Random random(run);
    const std::vector<double> squared = residuals(1, 2000, 0.02, 1.5, random);
    kind.background = 0;
    without += std::abs(estimateNoiseScale(squared, kind).sigma - 1.5) / kRuns;
    kind.background = 1960 / 320.0;
    with += std::abs(estimateNoiseScale(squared, kind).sigma - 1.5) / kRuns;
  }
  EXPECT_LT(with, 0.9 * without);
}

TEST(NoiseScale, DoesNotDependOnTheOrder) {
  Random random(3);
  std::vector<double> squared = residuals(2, 500, 0.4, 0.7, random);
  const NoiseScale found = estimateNoiseScale(squared, kHomographyKind);
  std::reverse(squared.begin(), squared.end());
  std::swap(squared[3], squared[400]);
  EXPECT_EQ(estimateNoiseScale(squared, kHomographyKind).sigma, found.sigma);
  EXPECT_EQ(estimateNoiseScale(squared, kHomographyKind).inliers, found.inliers);
}

TEST(NoiseScale, StaysWithinItsBounds) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(estimateNoiseScale({}, kHomographyKind).sigma));
  EXPECT_TRUE(std::isnan(estimateNoiseScale({infinity, nan, 1e9}, kHomographyKind).sigma));
  EXPECT_TRUE(std::isnan(estimateNoiseScale({0.1, 0.2, 0.1, 0.2}, kHomographyKind).sigma)) << "exact fit";
  EXPECT_NEAR(estimateNoiseScale(std::vector<double>(50, 0.0), kHomographyKind).sigma, 0.1, 0.01);
  Random random(0);
  std::vector<double> uniform;
  for (int i = 0; i < 500; ++i) uniform.push_back(std::pow(random.uniform(0, 10), 2));
  const double sigma = estimateNoiseScale(uniform, kFundamentalKind).sigma;
  EXPECT_TRUE(std::isnan(sigma) || (sigma >= 0.1 && sigma <= 10)) << sigma;
}

}  // namespace
}  // namespace corrsel::core
