#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "feature_checks.h"
#include "features/descriptors/orb_pattern.h"
#include "features/parts/oriented_patch.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class OrientedPatchTest : public ::testing::Test {
  LevelGuard guard_;
};

/// One level with its blurred image.
struct OneLevel {
  explicit OneLevel(const cv::Mat& image) {
    pyramid.start(image, 1.2, 1, true);
    pyramid.blur(0, cv::Rect(3, 3, image.cols - 6, image.rows - 6), Workspace::ofThread());
  }
  ImagePyramid pyramid;
};

/// Shapes with a slope of brightness, so that no patch is blank.
cv::Mat textured() {
  cv::Mat image = shapes(1, {400, 400});
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      auto& grey = image.at<std::uint8_t>(y, x);
      grey = cv::saturate_cast<std::uint8_t>(grey / 2 + (x * 3 + y) % 97);
    }
  }
  return image;
}

TEST(AngleOf, IsThatOfTheVector) {
  for (int i = 0; i < 3600; ++i) {
    const double angle = i * (CV_PI / 1800), length = 1 + 1000.0 * (i % 7);
    const auto x = float(length * std::cos(angle)), y = float(length * std::sin(angle));
    double expected = std::atan2(double(y), double(x)) * 180 / CV_PI;
    if (expected < 0) expected += 360;
    const float found = angleOf(x, y);
    EXPECT_GE(found, 0);
    EXPECT_LT(found, 360);
    EXPECT_LT(std::abs(std::remainder(found - expected, 360)), 1e-4) << angle;
  }
  EXPECT_EQ(angleOf(0, 0), 0);
  EXPECT_EQ(angleOf(2, 0), 0);
  EXPECT_EQ(angleOf(0, 3), 90);
  EXPECT_EQ(angleOf(-1, 0), 180);
  EXPECT_EQ(angleOf(0, -7), 270);
}

TEST(OrbPattern, HasDifferentTestsInsideThePatch) {
  std::set<std::array<int, 4>> tests;
  for (const OrbTest& test : kOrbPattern) {
    EXPECT_LE(test.x1 * test.x1 + test.y1 * test.y1, kOrbRadius * kOrbRadius);
    EXPECT_LE(test.x2 * test.x2 + test.y2 * test.y2, kOrbRadius * kOrbRadius);
    // The windows of 5 px do not overlap.
    EXPECT_GE(std::max(std::abs(test.x1 - test.x2), std::abs(test.y1 - test.y2)), 5);
    tests.insert({test.x1, test.y1, test.x2, test.y2});
    tests.insert({test.x2, test.y2, test.x1, test.y1});
  }
  EXPECT_EQ(tests.size(), 2 * kOrbTests);
}

TEST_F(OrientedPatchTest, DirectionIsThatOfTheCentroidAtEveryLevel) {
  const cv::Mat image = textured();
  OneLevel one(image);
  for (const int size : {5, 6, 31, 32, 63, 64, 65, 126, 127}) {
    const OrientedPatch patch(size);
    const int radius = size / 2;
    for (const cv::Point at :
         {cv::Point(63, 63), cv::Point(200, 180), cv::Point(336, 336), cv::Point(101, 250)}) {
      double mx = 0, my = 0;
      for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
          if (std::hypot(x, y) >= radius + 0.5) continue;
          mx += x * int(image.at<std::uint8_t>(at.y + y, at.x + x));
          my += y * int(image.at<std::uint8_t>(at.y + y, at.x + x));
        }
      }
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        const PatchDirection found = patch.direction(one.pyramid.level(0), at.x, at.y);
        ASSERT_EQ(found.angle, angleOf(float(mx), float(my))) << toString(level) << " " << size;
        ASSERT_NEAR(found.cosine, mx / std::hypot(mx, my), 1e-6);
        ASSERT_NEAR(found.sine, my / std::hypot(mx, my), 1e-6);
      }
    }
  }
  const OneLevel blank(cv::Mat(64, 64, CV_8U, cv::Scalar(200)));
  const PatchDirection none = OrientedPatch(31).direction(blank.pyramid.level(0), 32, 32);
  EXPECT_EQ(none.angle, 0);
  EXPECT_EQ(none.cosine, 1);
  EXPECT_EQ(none.sine, 0);
}

TEST_F(OrientedPatchTest, BitsAreTheTurnedTestsAtEveryLevel) {
  const cv::Mat image = textured();
  OneLevel one(image);
  const PyramidLevel blurred = one.pyramid.blurred(0);
  for (const int size : {5, 31, 40, 127}) {
    const OrientedPatch patch(size);
    const double scale = (size / 2) / double(kOrbRadius);
    for (const float angle : {0.0F, 1.0F, 2.0F, 90.0F, 123.4F, 270.0F, 359.0F}) {
      for (const cv::Point at : {cv::Point(66, 66), cv::Point(200, 180), cv::Point(333, 333)}) {
        const int direction = OrientedPatch::numberOf(angle);
        std::array<std::uint8_t, OrientedPatch::kBytes> expected{}, found{};
        for (std::size_t i = 0; i < kOrbTests; ++i) {
          const OrbTest& test = kOrbPattern[i];
          const auto pixel = [&](int x, int y) {
            const cv::Point place = at + OrientedPatch::turned(x * scale, y * scale, direction);
            return blurred.pixels[place.y * blurred.stride + place.x];
          };
          if (pixel(test.x1, test.y1) < pixel(test.x2, test.y2))
            expected[i / 8] |= std::uint8_t(1U << (i % 8));
        }
        for (const KernelLevel level : supportedKernelLevels()) {
          setKernelLevel(level);
          patch.describe(blurred, at.x, at.y, angle, found.data());
          ASSERT_EQ(found, expected) << toString(level) << " " << size << " " << angle;
        }
      }
    }
  }
}

TEST_F(OrientedPatchTest, TurnedPlacesStayInThePatch) {
  for (int direction = 0; direction < OrientedPatch::kDirections; ++direction) {
    const double angle = direction * 2 * CV_PI / OrientedPatch::kDirections;
    for (const OrbTest& test : kOrbPattern) {
      const cv::Point place = OrientedPatch::turned(test.x1, test.y1, direction);
      EXPECT_LE(std::max(std::abs(place.x), std::abs(place.y)), kOrbRadius);
      EXPECT_LE(std::abs(place.x - (std::cos(angle) * test.x1 - std::sin(angle) * test.y1)), 0.501);
      EXPECT_LE(std::abs(place.y - (std::sin(angle) * test.x1 + std::cos(angle) * test.y1)), 0.501);
    }
    EXPECT_EQ(OrientedPatch::numberOf(float(angle * 180 / CV_PI)), direction);
  }
  EXPECT_EQ(OrientedPatch::numberOf(359.9F), 0);
}

}  // namespace
}  // namespace corrsel::core
