#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "calibrated_scene.h"
#include "cameras.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"
#include "geometry/residual.h"
#include "search/essential_model.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using calibrated_scene::generate;
using calibrated_scene::Scene;
using pose_scene::angleBetween;
using testing::allCameras;
using testing::contains;
using testing::LevelGuard;

calibrated_scene::SceneOptions sceneOptions(const Camera& camera, std::size_t size = 300) {
  calibrated_scene::SceneOptions options;
  options.camera = camera;
  options.size = size;
  return options;
}

std::vector<std::uint32_t> allRows(std::size_t n) {
  std::vector<std::uint32_t> rows(n);
  std::iota(rows.begin(), rows.end(), 0U);
  return rows;
}

/// The rays of a scene in both precisions.
struct SceneRays {
  RayMatches rays;
  NormalizedMatches matches;

  explicit SceneRays(const Correspondences& pairs) {
    std::vector<std::uint8_t> exists;
    EXPECT_EQ(unproject(pairs, rays, exists), 0U);
    takeRays(pairs, rays, allRows(pairs.size()), matches);
  }
};

MatchColumns firstMatches(const RayColumns& rays, std::size_t n) {
  return {nullptr, nullptr, nullptr, nullptr, n, rays.left.data(), rays.right.data(), rays.size};
}

double meanLoss(const RayMatches& rays, const std::vector<std::uint8_t>& inlier, const cv::Matx33d& essential,
                double threshold) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (inlier[i] == 0) continue;
    const double r = tangentSampson(essential, rays, i) / threshold;
    sum += r * r / (1 + r * r);
    ++count;
  }
  return sum / count;
}

TEST(EssentialModel, ErrorsAndScoresAreTheSameAtEveryLevel) {
  const LevelGuard guard;
  const auto number = static_cast<std::size_t>(Residual::kTangentSampson);
  const Scene scene = generate(sceneOptions(pose_scene::fisheye()), 1);
  const SceneRays rays(scene.matches);
  const ResidualModel model = residualModel(Residual::kTangentSampson, essentialOf(scene.truth));
  for (std::size_t n = 1; n < 300; n += 2) {
    const MatchColumns m = firstMatches(rays.matches.rays, n);
    ScoreRule rule{6.25F, ScoreRule::kOutlierCost / 6.25F, std::int64_t(n) * ScoreRule::kOutlierCost};
    rule.start = n > 40 ? 32 : 0;
    setKernelLevel(KernelLevel::kPlain);
    std::vector<float> expected(n), errors(n);
    kernels().residuals.errors[number](model, m, 0, n, expected.data());
    const ModelScore wanted = kernels().residuals.score[number](model, m, rule);
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      kernels().residuals.errors[number](model, m, 0, n, errors.data());
      ASSERT_EQ(errors, expected) << toString(level) << ", n = " << n;
      const ModelScore score = kernels().residuals.score[number](model, m, rule);
      ASSERT_EQ(score.cost, wanted.cost) << toString(level) << ", n = " << n;
      ASSERT_EQ(score.inliers, wanted.inliers) << toString(level) << ", n = " << n;
      ASSERT_EQ(score.seen, wanted.seen) << toString(level) << ", n = " << n;
    }
  }
}

TEST(EssentialModel, ErrorsAreThoseInDoublePrecision) {
  for (const auto& [name, camera] : allCameras()) {
    const Scene scene = generate(sceneOptions(camera), 2);
    const SceneRays rays(scene.matches);
    const cv::Matx33d essential = essentialOf(scene.truth) * std::sqrt(0.5);
    std::vector<float> errors(rays.matches.size());
    modelErrors(Residual::kTangentSampson, essential, rays.matches, 0, errors.size(), errors.data());
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const double expected = std::abs(tangentSampson(essential, rays.rays, i));
      ASSERT_NEAR(std::sqrt(errors[i]), expected, 1e-3 * (1 + expected)) << name << ", match " << i;
    }
  }
}

TEST(EssentialModel, RepairedErrorsAreThoseOfMatchesWithOtherRightPoints) {
  const Scene scene = generate(sceneOptions(pose_scene::fisheye(), 101), 3);
  const SceneRays rays(scene.matches);
  const std::size_t n = rays.rays.size();
  const cv::Matx33d essential = essentialOf(scene.truth);
  for (const std::size_t shift : {0, 1, 7, 50, 100}) {
    std::vector<std::uint32_t> rows = allRows(n);
    std::rotate(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(shift), rows.end());
    RayMatches repaired;
    gatherRays(rays.rays, rows, repaired);
    repaired.left = rays.rays.left;
    std::vector<float> errors(n);
    repairedErrors(essential, rays.matches.rays, shift, errors.data());
    for (std::size_t i = 0; i < n; ++i) {
      const double expected = std::abs(tangentSampson(essential, repaired, i));
      ASSERT_NEAR(std::sqrt(errors[i]), expected, 1e-3 * (1 + expected)) << shift << ", match " << i;
    }
  }
}

TEST(EssentialModel, SolvesManySamplesLikeSingleOnes) {
  const Scene scene = generate(sceneOptions(pose_scene::pinhole()), 4);
  const SceneRays rays(scene.matches);
  const EssentialModel model;
  Random random(5);
  int solutions = 0;
  for (int count = 1; count <= model.traits.batch; ++count) {
    Hypotheses batch[kMaxBatch];
    for (int b = 0; b < count; ++b)
      for (int k = 0; k < 5; ++k) batch[b].sample[k] = random.index(300);
    model.solveBatch(rays.matches, batch, count);
    for (int b = 0; b < count; ++b) {
      cv::Matx33d single[Model::kMaxModels];
      ASSERT_EQ(model.solve(rays.matches, batch[b].sample, single), batch[b].count);
      for (int k = 0; k < batch[b].count; ++k) ASSERT_EQ(single[k], batch[b].models[k]);
      solutions += batch[b].count;
    }
  }
  EXPECT_GT(solutions, 72);  // of 36 samples; 4.5 each in the mean
}

TEST(EssentialModel, RefinementLowersTheLoss) {
  const double threshold = 2.5;
  for (const auto& [name, camera] : allCameras()) {
    const Scene scene = generate(sceneOptions(camera), 6);
    const SceneRays rays(scene.matches);
    const Pose start = moved(scene.truth, {2e-3, -2e-3, 2e-3, 0.02, -0.02});
    const cv::Matx33d before = essentialOf(start);
    cv::Matx33d essential = before;
    ASSERT_TRUE(EssentialModel().refine(rays.matches, threshold * threshold, essential)) << name;
    EXPECT_NEAR(cv::norm(essential), 1, 1e-12) << name;
    EXPECT_LT(meanLoss(rays.rays, scene.inlier, essential, threshold),
              0.9 * meanLoss(rays.rays, scene.inlier, before, threshold))
        << name;
  }
}

TEST(EssentialModel, DoesNotRefineWhatNoMatchAgreesWith) {
  const Scene scene = generate(sceneOptions(pose_scene::pinhole(), 20), 7);
  const SceneRays rays(scene.matches);
  cv::Matx33d essential = essentialOf(moved(scene.truth, {1, 1, 1, 1, 1}));
  EXPECT_FALSE(EssentialModel().refine(rays.matches, 1e-6F, essential));
}

TEST(EssentialModel, SearchesFindIt) {
  for (const auto& [name, camera] : allCameras()) {
    for (const std::string spec : {"usac:e", "acransac:e"}) {
      SCOPED_TRACE(spec + ", " + name);
      const Scene scene = generate(sceneOptions(camera), 8);
      const OptionMap options = spec == "usac:e" ? OptionMap{{"threshold", "2.5"}} : OptionMap{};
      const Selection selection = createSelector(spec, options)->select(scene.matches);
      EXPECT_EQ(selection.status, Status::kOk) << selection.message;
      ASSERT_EQ(selection.model_kind, ModelKind::kEssential);
      const testing::Quality quality = testing::quality(selection.mask, scene.inlier);
      EXPECT_GT(quality.precision, 90);
      EXPECT_GT(quality.recall, 90);
      Pose poses[4];
      ASSERT_TRUE(posesOf(selection.model, poses));
      double error = 10;
      for (const Pose& pose : poses) {
        error = std::min(error, cv::norm(pose.rotation - scene.truth.rotation) +
                                    angleBetween(pose.translation, scene.truth.translation));
      }
      EXPECT_LT(error, 0.05);
    }
  }
}

TEST(EssentialModel, NeedsCameras) {
  Scene scene = generate(sceneOptions(pose_scene::pinhole()), 9);
  scene.matches.right_camera.reset();
  for (const std::string spec : {"usac:e", "acransac:e"}) {
    const Selection selection = createSelector(spec)->select(scene.matches);
    EXPECT_EQ(selection.status, Status::kUnsupportedInput) << spec;
    EXPECT_TRUE(contains(selection.message, "right camera")) << selection.message;
  }
}

}  // namespace
}  // namespace corrsel::core
