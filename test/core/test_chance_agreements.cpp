#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "calibrated/chance_agreements.h"
#include "calibrated_scene.h"
#include "geometry/essential.h"

namespace corrsel::core {
namespace {

using namespace calibrated_scene;

constexpr double kThresholdPerNoise = 2.5;

/// The chance agreements of a scene under its true pose.
struct Measured {
  RayMatches rays;
  RayColumns columns;
  std::vector<std::uint32_t> agreeing;
  ChanceAgreements chance;

  Measured(const Scene& scene, double threshold) {
    std::vector<std::uint8_t> exists;
    unproject(scene.matches, rays, exists);
    std::vector<std::uint32_t> rows(rays.size());
    std::iota(rows.begin(), rows.end(), 0U);
    columns.take(rays, rows);
    const cv::Matx33d essential = essentialOf(scene.truth);
    for (const std::uint32_t i : rows) {
      const bool agrees = std::abs(tangentSampson(essential, rays, i)) <= threshold;
      if (agrees && isInFront(scene.truth, rays, i, threshold)) agreeing.push_back(i);
    }
    chance.measure(scene.truth, rays, columns, agreeing, rays.size() - agreeing.size(), threshold);
  }

  double displacement(const Pose& pose, std::uint32_t i) const {
    return cv::norm(pose.rotation * rays.left.direction(i) - rays.right.direction(i));
  }
};

SceneOptions fewInliers(const Camera& camera) {
  SceneOptions options;
  options.camera = camera;
  options.size = 400;
  options.right_share = 0.3;
  options.noise = 2;
  options.baseline = 0.15;
  return options;
}

TEST(ChanceAgreements, InliersCountAndFarOutliersDoNot) {
  for (const Camera& camera : pose_scene::cameras()) {
    double inliers = 0, counting_inliers = 0, far = 0, counting_far = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const SceneOptions options = fewInliers(camera);
      const Scene scene = generate(options, seed);
      const Measured measured(scene, kThresholdPerNoise * options.noise);
      double largest = 0;
      for (const std::uint32_t i : measured.agreeing)
        if (scene.inlier[i] != 0) largest = std::max(largest, measured.displacement(scene.truth, i));
      for (const std::uint32_t i : measured.agreeing) {
        const double counts = measured.chance.counts(scene.truth, measured.rays, i) ? 1 : 0;
        if (scene.inlier[i] != 0) {
          ++inliers;
          counting_inliers += counts;
        } else if (measured.displacement(scene.truth, i) > 1.5 * largest) {
          ++far;
          counting_far += counts;
        }
      }
    }
    SCOPED_TRACE(toString(camera.model) + ": " + std::to_string(counting_far) + " of " + std::to_string(far));
    EXPECT_GT(counting_inliers, 0.98 * inliers);
    ASSERT_GE(far, 10);
    EXPECT_LT(counting_far, 0.2 * far);
  }
}

TEST(ChanceAgreements, ExpectsAsManyAsThereAre) {
  for (const Camera& camera : pose_scene::cameras()) {
    double expected = 0, counting = 0, share = 0, agreeing = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const SceneOptions options = fewInliers(camera);
      const Scene scene = generate(options, seed);
      const Measured measured(scene, kThresholdPerNoise * options.noise);
      expected += measured.chance.expectedAmongCounting();
      share += measured.chance.share() * 0.7 * 400;
      for (const std::uint32_t i : measured.agreeing) {
        if (scene.inlier[i] != 0) continue;
        ++agreeing;
        counting += measured.chance.counts(scene.truth, measured.rays, i) ? 1 : 0;
      }
    }
    SCOPED_TRACE(toString(camera.model) + ": " + std::to_string(expected) + " expected, " +
                 std::to_string(counting) + " counting; " + std::to_string(share) + " of " +
                 std::to_string(agreeing));
    EXPECT_LT(expected, 1.5 * counting);
    EXPECT_GT(expected, counting / 1.5);
    EXPECT_LT(share, 1.5 * agreeing);
    EXPECT_GT(share, agreeing / 1.5);
  }
}

TEST(ChanceAgreements, AllCountWhereThereAreNoOutliers) {
  SceneOptions options = fewInliers(pose_scene::pinhole());
  options.right_share = 1;
  const Scene scene = generate(options, 3);
  Measured measured(scene, 6 * options.noise);
  EXPECT_EQ(measured.agreeing.size(), options.size);
  EXPECT_EQ(measured.chance.expectedAmongCounting(), 0);
  for (const std::uint32_t i : measured.agreeing)
    EXPECT_TRUE(measured.chance.counts(scene.truth, measured.rays, i));
}

TEST(ChanceAgreements, ForgetsAMeasurement) {
  const SceneOptions options = fewInliers(pose_scene::pinhole());
  const Scene scene = generate(options, 4);
  Measured measured(scene, kThresholdPerNoise * options.noise);
  ASSERT_GT(measured.chance.share(), 0);
  measured.chance.clear();
  EXPECT_EQ(measured.chance.share(), 0);
  EXPECT_EQ(measured.chance.expectedAmongCounting(), 0);
  for (const std::uint32_t i : measured.agreeing)
    EXPECT_TRUE(measured.chance.counts(scene.truth, measured.rays, i));
}

}  // namespace
}  // namespace corrsel::core
