#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

#include "corrsel/random.h"
#include "evaluation/repeatability.h"

namespace corrsel::core {
namespace {

AffineFrame disc(double x, double y, double radius) {
  return {float(radius), 0, float(x), 0, float(radius), float(y)};
}

/// Features at random places, with axes of random lengths and directions.
std::vector<AffineFrame> randomFrames(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<AffineFrame> frames;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = 640 * random.uniform(), y = 480 * random.uniform();
    const double radius = 3 + 20 * random.uniform(), tilt = 1 + random.uniform();
    const double angle = 6 * random.uniform();
    const double c = std::cos(angle), s = std::sin(angle);
    frames.push_back({float(radius * tilt * c), float(-radius * s), float(x), float(radius * tilt * s),
                      float(radius * c), float(y)});
  }
  return frames;
}

/// The frame turned about its centre: another orientation of the same region.
AffineFrame turned(const AffineFrame& f, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {float(f[0] * c + f[1] * s), float(f[1] * c - f[0] * s), f[2],
          float(f[3] * c + f[4] * s), float(f[4] * c - f[3] * s), f[5]};
}

/// The frame under an affine map.
AffineFrame mapped(const cv::Matx33d& h, const AffineFrame& f) {
  const cv::Matx23d m(h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2));
  const cv::Matx33d frame(f[0], f[1], f[2], f[3], f[4], f[5], 0, 0, 1);
  const cv::Matx23d r = m * frame;
  return {float(r(0, 0)), float(r(0, 1)), float(r(0, 2)), float(r(1, 0)), float(r(1, 1)), float(r(1, 2))};
}

/// Intersection divided by union, by counting points of a fine grid.
double countedOverlap(const AffineFrame& a, const AffineFrame& b) {
  const auto contains = [](const AffineFrame& f, double x, double y) {
    const cv::Matx22d inverse = cv::Matx22d(f[0], f[1], f[3], f[4]).inv();
    const cv::Vec2d p = inverse * cv::Vec2d(x - f[2], y - f[5]);
    return p.dot(p) <= 1;
  };
  int both = 0, any = 0;
  for (double y = -60; y < 60; y += 0.1) {
    for (double x = -60; x < 60; x += 0.1) {
      const bool first = contains(a, x, y), second = contains(b, x, y);
      both += first && second;
      any += first || second;
    }
  }
  return double(both) / any;
}

TEST(EllipseOverlap, OfDiscsIsThatOfTheFormula) {
  EXPECT_NEAR(ellipseOverlap(disc(5, 7, 3), disc(5, 7, 3)), 1, 1e-3);
  EXPECT_NEAR(ellipseOverlap(disc(5, 7, 3), disc(5, 7, 6)), 0.25, 1e-3);
  EXPECT_EQ(ellipseOverlap(disc(0, 0, 1), disc(2.1, 0, 1)), 0);
  for (const double d : {0.1, 0.5, 1.0, 1.9}) {
    const double lens = 2 * std::acos(d / 2) - d / 2 * std::sqrt(4 - d * d), all = 2 * CV_PI - lens;
    EXPECT_NEAR(ellipseOverlap(disc(3, 4, 10), disc(3 + 6 * d, 4 + 8 * d, 10)), lens / all, 1e-3) << d;
  }
}

TEST(EllipseOverlap, OfEllipsesIsThatOfCounting) {
  const std::vector<AffineFrame> frames = randomFrames(12, 1);
  for (std::size_t i = 0; i + 1 < frames.size(); i += 2) {
    AffineFrame a = frames[i], b = frames[i + 1];
    a[2] = 3;
    a[5] = -2;
    b[2] = b[5] = 1;
    EXPECT_NEAR(ellipseOverlap(a, b), countedOverlap(a, b), 5e-3) << i;
    EXPECT_NEAR(ellipseOverlap(a, b), ellipseOverlap(b, a), 2e-3) << i;
  }
}

TEST(EllipseOverlap, ScalesAboutTheCentres) {
  EXPECT_NEAR(ellipseOverlap(disc(0, 0, 1), disc(1.5, 0, 1), 10),
              ellipseOverlap(disc(0, 0, 10), disc(1.5, 0, 10)), 1e-12);
}

TEST(EllipseOverlap, IsZeroWithoutARegion) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(ellipseOverlap({0, 0, 1, 0, 0, 1}, disc(1, 1, 1)), 0);
  EXPECT_EQ(ellipseOverlap(disc(1, 1, 1), {nan, 0, 1, 0, 1, 1}), 0);
}

TEST(Repeatability, IsOneForTheSameRegionsUnderAnAffineMap) {
  const cv::Matx33d h(0.9, 0.2, 60, -0.1, 1.1, 80, 0, 0, 1);
  const std::vector<AffineFrame> left = randomFrames(500, 2);
  std::vector<AffineFrame> right;
  for (const AffineFrame& f : left) right.push_back(mapped(h, f));
  const cv::Size size(640, 480), large(5000, 5000);
  for (const double sign : {1.0, -2.0}) {
    Repeatability found = repeatability(left, size, right, large, h * sign);
    EXPECT_EQ(found.left, 500u);
    EXPECT_EQ(found.left, found.right);
    EXPECT_EQ(found.repeated, found.left);
    EXPECT_EQ(found.share(), 1);
  }
  // Neither their order nor their orientation matters.
  std::reverse(right.begin(), right.end());
  for (AffineFrame& f : right) f = turned(f, 1);
  EXPECT_EQ(repeatability(left, size, right, large, h).share(), 1);
}

TEST(Repeatability, CountsEveryRegionOnce) {
  const cv::Size size(640, 480);
  const cv::Matx33d identity = cv::Matx33d::eye();
  // The better of two pairs, one to one; orientations do not add regions.
  const std::vector<AffineFrame> left = {disc(100, 100, 10), disc(102, 100, 10),
                                         turned(disc(102, 100, 10), 1)};
  const Repeatability found = repeatability(left, size, {disc(101.5, 100, 10)}, size, identity);
  EXPECT_EQ(found.left, 2u);
  EXPECT_EQ(found.right, 1u);
  EXPECT_EQ(found.repeated, 1u);
  EXPECT_EQ(found.share(), 1);
}

TEST(Repeatability, AllowsAnOverlapErrorOf40Percent) {
  const cv::Size size(640, 480);
  const auto repeated = [&size](const AffineFrame& left, const AffineFrame& right) {
    return repeatability({left}, size, {right}, size, cv::Matx33d::eye()).repeated;
  };
  // Of concentric discs, the overlap is the ratio of the areas.
  EXPECT_EQ(repeated(disc(50, 50, 10), disc(50, 50, 10 * std::sqrt(0.61))), 1u);
  EXPECT_EQ(repeated(disc(50, 50, 10), disc(50, 50, 10 * std::sqrt(0.59))), 0u);
  EXPECT_EQ(repeated(disc(50, 50, 10), disc(50, 50, 10 / std::sqrt(0.61))), 1u);
  EXPECT_EQ(repeated(disc(50, 50, 10), disc(50, 50, 10 / std::sqrt(0.59))), 0u);
  // Equal discs overlap by 60 % at 0.40 radii, whatever their size: all are scaled to 30 px.
  for (const double radius : {2.0, 10.0, 200.0}) {
    EXPECT_EQ(repeated(disc(50, 50, radius), disc(61, 50, radius)), 1u) << radius;
    EXPECT_EQ(repeated(disc(50, 50, radius), disc(63, 50, radius)), 0u) << radius;
  }
}

TEST(Repeatability, CountsWhatBothImagesShow) {
  const cv::Size size(100, 100);
  const cv::Matx33d shift(1, 0, 50, 0, 1, 0, 0, 0, 1);
  const std::vector<AffineFrame> left = {disc(20, 50, 5), disc(80, 50, 5)};
  const std::vector<AffineFrame> right = {disc(70, 50, 5), disc(10, 50, 5), disc(90, 90, 5)};
  const Repeatability found = repeatability(left, size, right, size, shift);
  EXPECT_EQ(found.left, 1u);
  EXPECT_EQ(found.right, 2u);
  EXPECT_EQ(found.repeated, 1u);
  EXPECT_TRUE(std::isnan(repeatability({}, size, right, size, shift).share()));
  // Behind the camera.
  const cv::Matx33d horizon(1, 0, 0, 0, 1, 0, -0.015, 0, 1);
  EXPECT_EQ(repeatability({disc(80, 50, 5)}, size, {}, {10000, 10000}, horizon).left, 0u);
}

TEST(Agreement, ComparesPlaceAndScale) {
  const std::vector<AffineFrame> frames = {disc(10, 10, 4), disc(50, 50, 4)};
  EXPECT_EQ(agreement(frames, frames, 0.5, 0.1), 1);
  EXPECT_EQ(agreement(frames, {turned(disc(10.3, 10.3, 4.3), 2)}, 0.5, 0.1), 0.5);
  EXPECT_EQ(agreement(frames, {disc(10.4, 10.4, 4)}, 0.5, 0.1), 0);
  EXPECT_EQ(agreement(frames, {disc(10, 10, 4.5)}, 0.5, 0.1), 0);
  EXPECT_EQ(agreement(frames, {disc(10, 10, 3.5)}, 0.5, 0.1), 0);
  EXPECT_EQ(agreement(frames, {}, 0.5, 0.1), 0);
  EXPECT_TRUE(std::isnan(agreement({}, frames, 0.5, 0.1)));
}

}  // namespace
}  // namespace corrsel::core
