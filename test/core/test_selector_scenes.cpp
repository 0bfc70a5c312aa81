#include <gtest/gtest.h>

#include "corrsel/datasets/scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::allSpecs;
using testing::quality;

/// The same matches with the right image shifted to the right.
MatchScene shifted(MatchScene scene, int shift) {
  for (float& x : scene.matches.right_x) x += float(shift);
  for (AffineFrame& frame : scene.matches.right_frame) frame[2] += float(shift);
  scene.matches.right_size.width += shift;
  return scene;
}

class OnScenes : public ::testing::TestWithParam<std::string> {
 protected:
  double f(const MatchScene& scene) const {
    const double value = quality(selector_->select(scene.matches).mask, scene.inlier).f;
    return std::isnan(value) ? 0 : value;
  }

  /// Matches of a scene. T-Linkage takes 0.2 s for 1000, which hundreds of scenes under the sanitizers
  /// multiply.
  std::size_t size() const { return selector_->name() == "tlinkage" ? 250 : 1000; }

 private:
  std::unique_ptr<Selector> selector_ = createSelector(GetParam());
};

/// A robot that stands still must not lose its matches.
TEST_P(OnScenes, CameraAtRestIsNoWorseThanAShiftedImage) {
  constexpr int kSeeds = 3;
  for (const double inlier_ratio : {1.0, 0.9, 0.5, 0.2}) {
    for (const double noise : {0.0, 0.1, 0.25, 0.5, 1.0, 2.0}) {
      double at_rest = 0, moved = 0;
      for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        SceneSpec spec{MatchSceneKind::kRest, size(), inlier_ratio, seed};
        spec.noise = noise;
        const MatchScene scene = makeScene(spec);
        at_rest += f(scene) / kSeeds;
        moved += f(shifted(scene, 40)) / kSeeds;
      }
      EXPECT_GE(at_rest, moved - 10) << "inlier ratio " << inlier_ratio << ", noise " << noise;
    }
  }
}

/// Rounded coordinates, as of ORB, leave many matches exactly at rest and the others at a distance of 1 px.
TEST_P(OnScenes, WholePixelsAtRestAreNoWorseThanAShiftedImage) {
  for (const double noise : {0.25, 0.5, 1.0}) {
    SceneSpec spec{MatchSceneKind::kRest, size(), 0.5, 1};
    spec.noise = noise;
    MatchScene scene = makeScene(spec);
    Correspondences& m = scene.matches;
    for (std::vector<float>* const column : {&m.left_x, &m.left_y, &m.right_x, &m.right_y}) {
      for (float& value : *column) value = std::round(value);
    }
    EXPECT_GE(f(scene), f(shifted(scene, 40)) - 10) << "noise " << noise;
  }
}

INSTANTIATE_TEST_SUITE_P(Selectors, OnScenes, ::testing::ValuesIn(allSpecs()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
});

/// What `auto` must find on one kind of scene.
struct Expectation {
  const char* name;
  MatchSceneKind kind;
  double noise, object_share;
  ModelKind model;
  double min_f[3];  // mean over seeds in percent, at inlier ratios of 90, 50 and 20 %
};

constexpr double kAutoInlierRatios[] = {0.9, 0.5, 0.2};

class AutoOnScenes : public ::testing::TestWithParam<Expectation> {};

/// The model is checked where half of the matches are inliers or more. With fewer, small objects and other
/// structures cannot be told from coherent outliers.
TEST_P(AutoOnScenes, FindsModelAndMatches) {
  const Expectation& expected = GetParam();
  const auto selector = createSelector("auto");
  constexpr int kSeeds = 3;
  for (std::size_t k = 0; k < 3; ++k) {
    // Everything, then no frames, then coordinates alone.
    for (int columns = 0; columns < 3; ++columns) {
      double f = 0;
      for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        SceneSpec spec{expected.kind, 1000, kAutoInlierRatios[k], seed};
        spec.noise = expected.noise;
        spec.object_share = expected.object_share;
        spec.frames = columns == 0;
        spec.distances = spec.sizes = columns < 2;
        const MatchScene scene = makeScene(spec);
        const Selection found = selector->select(scene.matches);
        EXPECT_EQ(found.status, Status::kOk) << found.message;
        EXPECT_GE(found.confidence, 4);
        f += quality(found.mask, scene.inlier).f / kSeeds;
        if (kAutoInlierRatios[k] >= 0.5) {
          EXPECT_EQ(found.model_kind, expected.model)
              << found.message << ", inlier ratio " << kAutoInlierRatios[k] << ", columns " << columns;
        }
      }
      EXPECT_GE(f, expected.min_f[k]) << "inlier ratio " << kAutoInlierRatios[k] << ", columns " << columns;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, AutoOnScenes,
    ::testing::Values(
        Expectation{"Plane", MatchSceneKind::kPlane, 1, 0, ModelKind::kHomography, {99, 99, 99}},
        Expectation{"Space", MatchSceneKind::kSpace, 1, 0, ModelKind::kFundamental, {90, 90, 35}},
        Expectation{"IdenticalImages", MatchSceneKind::kRest, 0, 0, ModelKind::kHomography, {99, 99, 99}},
        Expectation{"AtRest", MatchSceneKind::kRest, 0.1, 0, ModelKind::kHomography, {99, 99, 99}},
        Expectation{"AtRestWithNoise", MatchSceneKind::kRest, 2, 0, ModelKind::kHomography, {95, 95, 95}},
        Expectation{"Rotation", MatchSceneKind::kRotation, 1, 0, ModelKind::kHomography, {99, 99, 99}},
        Expectation{"Forward", MatchSceneKind::kForward, 1, 0, ModelKind::kFundamental, {98, 98, 98}},
        Expectation{
            "SmallObject", MatchSceneKind::kMovingObject, 1, 0.06, ModelKind::kFundamental, {98, 98, 94}},
        Expectation{"Object", MatchSceneKind::kMovingObject, 1, 0.15, ModelKind::kFundamental, {98, 98, 92}},
        Expectation{
            "LargeObject", MatchSceneKind::kMovingObject, 1, 0.3, ModelKind::kFundamental, {98, 98, 95}},
        Expectation{
            "PassingObject", MatchSceneKind::kPassingObject, 0.5, 0.3, ModelKind::kFundamental, {98, 97, 94}},
        Expectation{"TwoPlanes", MatchSceneKind::kTwoPlanes, 1, 0, ModelKind::kFundamental, {98, 98, 98}},
        Expectation{"Wall", MatchSceneKind::kWall, 1, 0, ModelKind::kFundamental, {98, 98, 98}},
        Expectation{"Facade", MatchSceneKind::kFacade, 1, 0, ModelKind::kHomography, {98, 98, 40}}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace corrsel::core
