#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "cameras.h"
#include "corrsel/camera_formats.h"
#include "geometry/rays.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Pixels {
  std::vector<float> x, y;

  std::size_t size() const { return x.size(); }
};

/// Pixels in the image of a camera.
Pixels pixelsOf(const Camera& camera, std::size_t n) {
  Random random(1);
  Pixels pixels;
  for (std::size_t i = 0; i < n; ++i) {
    pixels.x.push_back(static_cast<float>(random.uniform() * (camera.size.width - 1)));
    pixels.y.push_back(static_cast<float>(random.uniform() * (camera.size.height - 1)));
  }
  return pixels;
}

/// Some of them without a ray.
Pixels difficultPixelsOf(const Camera& camera, std::size_t n) {
  Pixels pixels = pixelsOf(camera, n);
  const std::vector<std::pair<float, float>> places = {
      {kNan, 5},      {5, kNan},      {kInfinity, 5}, {5, -kInfinity}, {1e6F, 0},  {0, -1e6F},
      {1e30F, 1e30F}, {3e38F, 3e38F}, {-900, 250},    {639.5, 479.5},  {690, 247}, {-0.5, -0.5}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    pixels.x[7 * i] = places[i].first;
    pixels.y[7 * i] = places[i].second;
  }
  return pixels;
}

std::size_t unproject(const Camera& camera, const Pixels& pixels, Rays& rays) {
  return core::unproject(camera, pixels.x.data(), pixels.y.data(), pixels.size(), rays);
}

class LevelGuard {
 public:
  ~LevelGuard() { setKernelLevel(level_); }

 private:
  KernelLevel level_ = kernelLevel();
};

TEST(Rays, AllKernelLevelsGiveTheSameBits) {
  const LevelGuard guard;
  for (const auto& [name, camera] : allCameras()) {
    const Pixels pixels = difficultPixelsOf(camera, 1001);
    setKernelLevel(KernelLevel::kPlain);
    Rays expected;
    const std::size_t missing = unproject(camera, pixels, expected);
    EXPECT_GE(missing, 4u) << name;
    EXPECT_LE(missing, 11u) << name;
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      Rays rays;
      EXPECT_EQ(unproject(camera, pixels, rays), missing) << name;
      for (std::size_t k = 0; k < Rays::kColumns; ++k) {
        EXPECT_EQ(std::memcmp(rays.column[k].data(), expected.column[k].data(), 1001 * sizeof(double)), 0)
            << name << " " << toString(level) << " column " << k;
      }
    }
  }
}

TEST(Rays, OneRayHasTheBitsOfTheSameAmongMany) {
  for (const auto& [name, camera] : allCameras()) {
    const Pixels pixels = difficultPixelsOf(camera, 301);
    Rays rays;
    std::size_t missing = unproject(camera, pixels, rays);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      Ray ray;
      missing -= core::unproject(camera, cv::Point2d(pixels.x[i], pixels.y[i]), ray) ? 0 : 1;
      const cv::Vec3d direction = rays.direction(i);
      const cv::Matx<double, 3, 2> jacobian = rays.jacobian(i);
      EXPECT_EQ(std::memcmp(ray.direction.val, direction.val, sizeof direction.val), 0) << name << " " << i;
      EXPECT_EQ(std::memcmp(ray.jacobian.val, jacobian.val, sizeof jacobian.val), 0) << name << " " << i;
    }
    EXPECT_EQ(missing, 0u) << name;
  }
}

/// Compares rays with points that OpenCV undistorted, where that converged.
/// @param images  of the undistorted points, projected by OpenCV
void expectLike(const Camera& camera, const Pixels& pixels, const std::vector<cv::Point2d>& undistorted,
                const std::vector<cv::Point2d>& images, const std::string& name) {
  Rays rays;
  ASSERT_EQ(unproject(camera, pixels, rays), 0u) << name;
  std::size_t converged = 0;
  double largest = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!(std::hypot(images[i].x - pixels.x[i], images[i].y - pixels.y[i]) < 1e-5)) continue;
    ++converged;
    const cv::Vec3d ray = rays.direction(i), expected(undistorted[i].x, undistorted[i].y, 1);
    largest = std::max(largest, cv::norm(ray - expected * (1 / cv::norm(expected))));
  }
  EXPECT_GT(converged, pixels.size() * 98 / 100) << name;
  EXPECT_LT(largest, 1e-6) << name;
  EXPECT_GT(largest, 0) << name;
}

std::vector<cv::Point2d> pointsOf(const Pixels& pixels) {
  std::vector<cv::Point2d> points;
  for (std::size_t i = 0; i < pixels.size(); ++i) points.emplace_back(pixels.x[i], pixels.y[i]);
  return points;
}

TEST(Rays, PinholesAreOpenCvs) {
  for (const auto& [name, camera] : {std::pair("radtan", radtanCamera()), {"rational", rationalCamera()}}) {
    const Pixels pixels = pixelsOf(camera, 100000);
    const std::vector<double> distortion = openCvDistortion(camera);
    std::vector<cv::Point2d> undistorted, images;
    cv::undistortPoints(pointsOf(pixels), undistorted, camera.matrix, distortion, cv::noArray(),
                        cv::noArray(),
                        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 300, 1e-10));
    std::vector<cv::Point3d> points;
    for (const cv::Point2d& point : undistorted) points.emplace_back(point.x, point.y, 1);
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera.matrix, distortion, images);
    expectLike(camera, pixels, undistorted, images, name);
  }
}

// OpenCV's points are on the plane z = 1, so those beside and behind the camera are left out.
TEST(Rays, FisheyesAreOpenCvs) {
  constexpr float kRadius = 500;  // px, 75 degrees
  const Camera camera = fisheyeCamera();
  const std::vector<double> distortion = openCvDistortion(camera);
  Pixels pixels;
  Random random(2);
  while (pixels.size() < 100000) {
    const float x = static_cast<float>(random.uniform() * 1279);
    const float y = static_cast<float>(random.uniform() * 959);
    if (std::hypot(x - 639.5F, y - 479.5F) > kRadius) continue;
    pixels.x.push_back(x);
    pixels.y.push_back(y);
  }
  std::vector<cv::Point2d> undistorted, images;
  cv::fisheye::undistortPoints(pointsOf(pixels), undistorted, camera.matrix, distortion);
  cv::fisheye::distortPoints(undistorted, images, camera.matrix, distortion);
  expectLike(camera, pixels, undistorted, images, "fisheye");
}

TEST(Rays, PixelAngleIsTheAngleToTheNextPixel) {
  const Camera camera = panoramaCamera();
  const Pixels pixels = {{1023.5F}, {511.5F}};
  Rays rays;
  EXPECT_EQ(unproject(camera, pixels, rays), 0u);
  EXPECT_NEAR(rays.pixelAngle(0), CV_PI / 1024, 1e-15);
  Camera pinhole;
  pinhole.matrix = {500, 0, 320, 0, 1000, 240, 0, 0, 1};
  EXPECT_EQ(unproject(pinhole, {{320}, {240}}, rays), 0u);
  EXPECT_NEAR(rays.pixelAngle(0), std::sqrt(0.5 * (4e-6 + 1e-6)), 1e-15);
}

Correspondences fiveMatches() {
  Correspondences matches;
  matches.left_camera = plainCamera();
  matches.right_camera = radtanCamera();
  for (int i = 0; i < 5; ++i) {
    const float x = 100.F + 10.F * static_cast<float>(i);
    matches.add({x, 50}, {2 * x, 60});
  }
  return matches;
}

TEST(Rays, MatchesWithoutARayAreMarked) {
  Correspondences matches = fiveMatches();
  RayMatches rays;
  std::vector<std::uint8_t> exists(9, 7);
  EXPECT_EQ(unproject(matches, rays, exists), 0u);
  EXPECT_EQ(exists, (std::vector<std::uint8_t>(5, 1)));
  EXPECT_EQ(rays.size(), 5u);
  EXPECT_EQ(rays.right.size(), 5u);
  Ray ray;
  ASSERT_TRUE(unproject(*matches.right_camera, cv::Point2d(260, 60), ray));
  EXPECT_EQ(rays.right.direction(3), ray.direction);

  matches.left_x[1] = kNan;
  matches.right_x[1] = kNan;
  matches.right_x[4] = -900;
  EXPECT_EQ(unproject(matches, rays, exists), 2u);
  EXPECT_EQ(exists, (std::vector<std::uint8_t>{1, 0, 1, 1, 0}));
}

TEST(Rays, GatheredRowsHaveTheGivenOrder) {
  RayMatches all, some;
  std::vector<std::uint8_t> exists;
  unproject(fiveMatches(), all, exists);
  gatherRays(all, {4, 0, 4}, some);
  ASSERT_EQ(some.size(), 3u);
  ASSERT_EQ(some.right.size(), 3u);
  const std::array<std::size_t, 3> rows = {4, 0, 4};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(some.left.direction(i), all.left.direction(rows[i]));
    EXPECT_EQ(some.left.jacobian(i), all.left.jacobian(rows[i]));
    EXPECT_EQ(some.right.direction(i), all.right.direction(rows[i]));
    EXPECT_EQ(some.right.jacobian(i), all.right.jacobian(rows[i]));
  }
}

TEST(Rays, NoPixelsAreNoRays) {
  Rays rays;
  rays.resize(3);
  EXPECT_EQ(unproject(radtanCamera(), Pixels{}, rays), 0u);
  EXPECT_EQ(rays.size(), 0u);
}

}  // namespace
}  // namespace corrsel::core
