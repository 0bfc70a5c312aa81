#include <gtest/gtest.h>

#include "corrsel/datasets/scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::quality;

/// Every selector and every preset: "name" or "name:preset".
std::vector<std::string> allSpecs() {
  std::vector<std::string> specs;
  for (const std::string& name : selectorNames()) {
    specs.push_back(name);
    for (const std::string& preset : selectorPresets(name)) specs.push_back(name + ":" + preset);
  }
  return specs;
}

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
        SceneSpec spec{SceneKind::kRest, 1000, inlier_ratio, seed};
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
    SceneSpec spec{SceneKind::kRest, 1000, 0.5, 1};
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

}  // namespace
}  // namespace corrsel::core
