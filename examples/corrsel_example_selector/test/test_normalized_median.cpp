#include <corrsel/datasets/scene.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "corrsel_example_selector/normalized_median.h"

namespace corrsel_example_selector {
namespace {

using namespace corrsel::core;

TEST(NormalizedMedian, KeepsTheRightMatchesOfAPlane) {
  SceneSpec spec;
  spec.n = 1000;
  spec.inlier_ratio = 0.7;
  const MatchScene scene = makeScene(spec);
  const Selection selection = NormalizedMedian().select(scene.matches);
  std::size_t right = 0, selected_right = 0;
  for (std::size_t i = 0; i < scene.matches.size(); ++i) {
    right += scene.inlier[i];
    selected_right += scene.inlier[i] && selection.mask[i];
  }
  EXPECT_EQ(selection.status, Status::kOk);
  EXPECT_GT(double(selected_right) / double(right), 0.7);
  EXPECT_GT(double(selected_right) / double(selection.n_selected), 0.95);
}

TEST(NormalizedMedian, SaysWhenThereAreTooFew) {
  Correspondences matches;
  for (int i = 0; i < 8; ++i) matches.add({float(i), 0}, {float(i + 1), 0});
  EXPECT_EQ(NormalizedMedian().select(matches).status, Status::kTooFew);
  matches.add({8, 0}, {9, 0});
  EXPECT_EQ(NormalizedMedian().select(matches).n_selected, 9u);
}

TEST(NormalizedMedian, TakesEqualPoints) {
  Correspondences matches;
  for (int i = 0; i < 40; ++i) matches.add({5, 5}, {i < 39 ? 6.0f : 50.0f, 5});
  EXPECT_EQ(NormalizedMedian().select(matches).n_selected, 39u);
}

TEST(NormalizedMedian, ChecksItsOptions) {
  NormalizedMedian selector;
  selector.configure({{"threshold", "3"}});
  EXPECT_EQ(listOptions(selector.options())[1].value, "3");
  EXPECT_THROW(selector.configure({{"threshold", "-1"}}), std::invalid_argument);
  EXPECT_THROW(selector.configure({{"treshold", "1"}}), std::invalid_argument);
}

TEST(NormalizedMedian, HasAPreset) {
  const Presets presets = NormalizedMedian().presets();
  ASSERT_EQ(presets.size(), 1u);
  EXPECT_EQ(presets[0].first, "strict");
  NormalizedMedian selector;
  selector.configure(presets[0].second);
  EXPECT_EQ(listOptions(selector.options())[0].value, "16");
}

}  // namespace
}  // namespace corrsel_example_selector
