#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "../core/test_support.h"
#include "add_test_selector.h"
#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/selectors/factory.h"
#include "fixed_pose_selector.h"
#include "passing_object.h"
#include "ros/live/live_selector.h"

namespace corrsel {
namespace {

/// A scene of n matches, 6 of 10 of them right.
Correspondences message(std::size_t n) {
  core::testing::SceneOptions options;
  options.n = n;
  PairInfo info;
  info.header.stamp.fromSec(7.0);
  info.header.frame_id = "left_optical";
  info.features = "given";
  return toMsg(core::testing::homographyScene(options).matches, info);
}

SelectorConfig config(const std::string& selector) {
  SelectorConfig config = SelectorConfig::__getDefault__();
  config.selector = selector;
  return config;
}

TEST(LiveSelector, SelectsAsTheCoreDoes) {
  LiveSelector selector;
  SelectorConfig asked = config("lpm");
  asked.lpm_k = 8;
  const LiveSelector::Change change = selector.configure(asked);
  EXPECT_EQ(change.error, "");
  EXPECT_EQ(change.spec, "lpm");

  const Correspondences input = message(250);
  const LiveSelector::Result result = selector.select(input, 0.25);
  const core::Selection expected = core::createSelector("lpm", {{"k", "8"}})->select(fromMsg(input));
  EXPECT_EQ(fromMsg(*result.selection).mask, expected.mask);
  EXPECT_EQ(result.matches->left_x.size(), expected.n_selected);
  EXPECT_EQ(result.matches->header.stamp, input.header.stamp);
  EXPECT_EQ(result.selection->header.frame_id, "left_optical");
  EXPECT_EQ(result.selection->selector, "lpm");
  EXPECT_DOUBLE_EQ(result.selection->seconds.wait, 0.25);
  EXPECT_GE(result.selection->seconds.publish, 0.0);
  EXPECT_GT(result.selection->seconds.select, 0.0);
  EXPECT_EQ(result.matches->seconds.select, result.selection->seconds.select);
  EXPECT_EQ(result.warning, "");
}

TEST(LiveSelector, LabelsWhatMovesWhereItIsAskedTo) {
  LiveSelector selector;
  SelectorConfig asked = config("auto");
  ASSERT_EQ(selector.configure(asked).error, "");
  const Correspondences input = testing::passingObject(ros::Time(7));
  const LiveSelector::Result without = selector.select(input, 0.0);
  EXPECT_FALSE(without.moving);
  EXPECT_TRUE(without.selection->motion.empty());

  asked.label_motion = true;
  ASSERT_EQ(selector.configure(asked).error, "");
  const LiveSelector::Result result = selector.select(input, 0.0);
  ASSERT_TRUE(result.moving);
  EXPECT_NEAR(result.moving->left_x.size(), testing::kObjectMatches, 2);
  EXPECT_EQ(result.moving->header.stamp, input.header.stamp);
  EXPECT_EQ(result.selection->motion,
            (std::vector<std::uint8_t>{Selection::GROUP_STATIC, Selection::GROUP_MOVING}));
  EXPECT_EQ(result.matches->left_x.size(), result.selection->n_selected);
  EXPECT_EQ(fromMsg(*result.selection).motion.at(1), core::GroupMotion::kMoving);
}

TEST(LiveSelector, PassesOnNoMatchesThatAreUncertain) {
  LiveSelector selector;
  SelectorConfig asked = config("lpm");
  ASSERT_EQ(selector.configure(asked).error, "");
  const Correspondences input = message(250);
  const LiveSelector::Result sure = selector.select(input, 0.0);
  EXPECT_GT(sure.selection->confidence, 10);
  EXPECT_EQ(sure.matches->left_x.size(), sure.selection->n_selected);

  asked.lpm_min_confidence = sure.selection->confidence + 1;
  ASSERT_EQ(selector.configure(asked).error, "");
  const LiveSelector::Result unsure = selector.select(input, 0.0);
  EXPECT_EQ(unsure.selection->status, Selection::STATUS_UNCERTAIN);
  EXPECT_EQ(unsure.selection->confidence, sure.selection->confidence);
  EXPECT_EQ(unsure.selection->mask, sure.selection->mask) << "it can still be looked at";
  EXPECT_TRUE(unsure.matches->left_x.empty());
  EXPECT_EQ(unsure.matches->header.stamp, input.header.stamp);
  EXPECT_EQ(unsure.warning.rfind("lpm: uncertain: the confidence is ", 0), 0u) << unsure.warning;
}

/// A mask for a left image of `message`, which excludes all up to a column.
PairMasks leftMask(int columns) {
  PairMasks masks;
  masks.left = cv::Mat(core::testing::kSceneHeight, core::testing::kSceneWidth, CV_8UC1, cv::Scalar(255));
  masks.left.colRange(0, columns).setTo(0);
  return masks;
}

/// Whether an array has the values of some rows in these rows and another value elsewhere; empty arrays
/// agree.
template <class Value>
bool isSpread(const std::vector<Value>& all, const std::vector<Value>& some,
              const std::vector<std::uint32_t>& rows, std::size_t n, Value of_others) {
  std::vector<Value> expected(some.empty() ? 0 : n, of_others);
  for (std::size_t i = 0; i < some.size(); ++i) expected[rows[i]] = some[i];
  return all == expected;
}

TEST(LiveSelector, RejectsTheMatchesOnMasksBeforeTheAlgorithm) {
  bool grouped = false, with_probability = false;
  for (const char* name : {"auto", "planes"}) {
    LiveSelector selector;
    SelectorConfig asked = config(name);
    ASSERT_EQ(selector.configure(asked).error, "");
    Correspondences input = message(400);
    input.left_x[7] = std::numeric_limits<float>::quiet_NaN();
    const LiveSelector::Result result = selector.select(input, 0.0, leftMask(300));
    const Selection& all = *result.selection;
    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < input.left_x.size(); ++i) {
      if (!(input.left_x[i] < 299.5F)) rows.push_back(i);
    }
    ASSERT_GT(rows.size(), 150u);
    ASSERT_LT(rows.size(), 350u);
    const core::Correspondences rest = fromMsg(input).subset(rows);
    core::Selection expected = core::createSelector(name)->select(rest);
    addConfidence(rest, expected);
    ASSERT_GT(expected.n_selected, 50u);

    EXPECT_EQ(all.mask_use, Selection::MASK_APPLIED);
    EXPECT_EQ(all.n_input, 400u);
    EXPECT_EQ(all.n_masked, 400u - rows.size());
    EXPECT_EQ(all.n_ignored, 1u);
    EXPECT_EQ(all.n_selected, expected.n_selected);
    EXPECT_EQ(all.confidence, expected.confidence);
    EXPECT_EQ(all.scene, static_cast<std::uint8_t>(expected.scene));
    const core::Selection back = fromMsg(all);  // throws where lengths or counts do not fit
    EXPECT_TRUE(isSpread(back.mask, expected.mask, rows, 400, std::uint8_t{0}));
    EXPECT_TRUE(isSpread(back.group, expected.group, rows, 400, -1));
    EXPECT_TRUE(isSpread(back.probability, expected.probability, rows, 400, 0.0F));
    EXPECT_EQ(result.matches->left_x.size(), expected.n_selected);
    for (const float x : result.matches->left_x) EXPECT_GE(x, 299.5F);
    grouped = grouped || !expected.group.empty();
    with_probability = with_probability || !expected.probability.empty();
  }
  EXPECT_TRUE(grouped && with_probability);
}

TEST(LiveSelector, ScoresOfMaskedMatchesAreNaN) {
  LiveSelector selector;
  SelectorConfig asked = config("nnsr");
  ASSERT_EQ(selector.configure(asked).error, "");
  Correspondences input = message(400);
  input.distance.resize(400);
  input.second_distance.assign(400, 1);
  for (std::size_t i = 0; i < 400; ++i) input.distance[i] = i % 3 == 0 ? 0.9F : 0.1F;
  const Selection result = *selector.select(input, 0.0, leftMask(300)).selection;
  ASSERT_EQ(result.score.size(), 400u);
  for (std::size_t i = 0; i < 400; ++i) EXPECT_EQ(std::isnan(result.score[i]), input.left_x[i] < 299.5F) << i;
}

TEST(LiveSelector, StatesWhatBecameOfTheMasks) {
  LiveSelector selector;
  SelectorConfig asked = config("lpm");
  ASSERT_EQ(selector.configure(asked).error, "");
  const Correspondences input = message(250);
  const Selection without = *selector.select(input, 0.0).selection;
  EXPECT_EQ(without.mask_use, Selection::MASK_UNUSED);
  EXPECT_EQ(without.n_masked, 0u);

  const Selection nothing = *selector.select(input, 0.0, leftMask(0)).selection;
  EXPECT_EQ(nothing.mask_use, Selection::MASK_APPLIED) << "a mask that excludes nothing";
  EXPECT_EQ(nothing.mask, without.mask);

  PairMasks missing = leftMask(300);
  missing.missing = true;
  const Selection one = *selector.select(input, 0.0, missing).selection;
  EXPECT_EQ(one.mask_use, Selection::MASK_MISSING);
  EXPECT_GT(one.n_masked, 0u) << "what is there counts";

  PairMasks odd;
  odd.right = cv::Mat::zeros(100, 100, CV_8UC1);
  const LiveSelector::Result refused = selector.select(input, 0.0, odd);
  EXPECT_EQ(refused.selection->mask_use, Selection::MASK_MISSING);
  EXPECT_EQ(refused.selection->mask, without.mask);
  EXPECT_NE(refused.warning.find("right mask has 100x100 px; needed: 800x600 px"), std::string::npos)
      << refused.warning;

  const LiveSelector::Result all = selector.select(input, 0.0, leftMask(800));
  EXPECT_EQ(all.selection->n_masked, 250u);
  EXPECT_EQ(all.selection->status, Selection::STATUS_TOO_FEW);
  EXPECT_EQ(all.selection->mask.size(), 250u);
}

TEST(LiveSelector, PassesOnAPoseWhereTheSelectorHasOne) {
  testing::addTestSelector<testing::FixedPoseSelector>();
  LiveSelector selector;
  SelectorConfig asked = config(testing::FixedPoseSelector::kName);
  ASSERT_EQ(selector.configure(asked).error, "");
  Correspondences input = message(70);
  const LiveSelector::Result without = selector.select(input, 0.0);
  EXPECT_FALSE(without.relative_pose || without.pose);
  EXPECT_EQ(without.verdict, "not estimated");

  core::Camera camera;
  camera.matrix = {500, 0, 400, 0, 500, 300, 0, 0, 1};
  input.left_camera = input.right_camera = toMsg(std::make_optional(camera));
  const LiveSelector::Result with = selector.select(input, 0.0);
  ASSERT_TRUE(with.relative_pose && with.pose);
  EXPECT_EQ(with.verdict, "general");
  EXPECT_EQ(with.relative_pose->header.stamp, input.header.stamp);
  EXPECT_EQ(with.relative_pose->selector, testing::FixedPoseSelector::kName);
  EXPECT_EQ(with.relative_pose->confidence, with.selection->confidence);
  EXPECT_FALSE(with.relative_pose->scale_known);
  EXPECT_EQ(with.pose->pose.pose.position.z, -1);
  EXPECT_EQ(with.matches->left_camera.model, Camera::MODEL_PINHOLE) << "the selected matches have them, too";

  input.rig_rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  input.rig_translation = {-0.12, 0, 0};
  const LiveSelector::Result rig = selector.select(input, 0.0);
  ASSERT_TRUE(rig.relative_pose && rig.pose);
  EXPECT_TRUE(rig.relative_pose->scale_known);
  EXPECT_DOUBLE_EQ(rig.pose->pose.pose.position.x, 0.12);

  asked.options = "motion=0";
  ASSERT_EQ(selector.configure(asked).error, "");
  const LiveSelector::Result none = selector.select(input, 0.0);
  EXPECT_TRUE(none.relative_pose);
  EXPECT_FALSE(none.pose);
  EXPECT_EQ(none.verdict, "none");
}

TEST(LiveSelector, WhatDoesNotWorkLeavesTheSelectorBeforeInForce) {
  LiveSelector selector;
  SelectorConfig good = config("vfc");
  good.vfc_lambda = 4.5;
  ASSERT_EQ(selector.configure(good).error, "");
  for (const char* name : {"nonsense", "", "no_such_package/Class"}) {
    SelectorConfig bad = config(name);
    const LiveSelector::Change change = selector.configure(bad);
    EXPECT_NE(change.error.find("selector not changed: "), std::string::npos) << name;
    EXPECT_NE(change.error.find("'vfc' stays in force"), std::string::npos) << change.error;
    EXPECT_EQ(change.spec, "vfc");
    EXPECT_EQ(bad.selector, "vfc") << "the configuration is written back as it is in force";
    EXPECT_EQ(bad.vfc_lambda, 4.5);
  }
  EXPECT_EQ(selector.select(message(70), 0.0).selection->selector, "vfc");
}

TEST(LiveSelector, RefusesOptionsInBracketsAndNamesTheParameter) {
  LiveSelector selector;
  SelectorConfig good = config("vfc");
  ASSERT_EQ(selector.configure(good).error, "");
  SelectorConfig bad = config("usac[threshold=3]");
  std::string error = selector.configure(bad).error;
  EXPECT_NE(error.find("'usac[threshold=3]': a nodelet takes no options in brackets; set the parameter "
                       "usac_threshold; 'vfc' stays in force"),
            std::string::npos)
      << error;
  bad = config("a/B[size=3]");
  error = selector.configure(bad).error;
  EXPECT_NE(error.find("set the parameter options to 'size=3'"), std::string::npos) << error;
  bad = config("lpm");
  bad.preset = "v2[k=5]";
  error = selector.configure(bad).error;
  EXPECT_NE(error.find("set the parameter lpm_k"), std::string::npos) << error;
}

TEST(LiveSelector, StartsWithTheDefaultWhereTheFirstConfigurationDoesNotWork) {
  LiveSelector selector;
  SelectorConfig bad = config("nonsense");
  const LiveSelector::Change change = selector.configure(bad);
  const std::string standard = SelectorConfig::__getDefault__().selector;
  EXPECT_NE(change.error.find("nonsense"), std::string::npos);
  EXPECT_EQ(change.spec, standard);
  EXPECT_EQ(bad.selector, standard);
  EXPECT_EQ(selector.select(message(70), 0.0).selection->selector, standard);
}

TEST(LiveSelector, APresetGoesWithItsSelector) {
  LiveSelector selector;
  SelectorConfig changing = config("usac");
  changing.preset = core::selectorPresets("usac").front();
  ASSERT_EQ(selector.configure(changing).error, "");
  EXPECT_EQ(changing.preset, core::selectorPresets("usac").front());

  changing.selector = "nnsr";
  const LiveSelector::Change change = selector.configure(changing);
  EXPECT_EQ(change.error, "");
  ASSERT_EQ(change.warnings.size(), 1u);
  EXPECT_NE(change.warnings[0].find("is not one of nnsr's and is cleared"), std::string::npos);
  EXPECT_EQ(changing.preset, "");

  changing.preset = "nonsense";  // asked for by name: an error, not a leftover
  EXPECT_NE(selector.configure(changing).error.find("nonsense"), std::string::npos);
}

TEST(LiveSelector, APresetSetsTheParametersThatDoNotChangeWithIt) {
  LiveSelector selector;
  SelectorConfig asked = config("lpm");
  const SelectorConfig standard = asked;
  asked.preset = "v2";
  asked.lpm_k = 7;
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_EQ(asked.lpm_cost, "multiscale");
  EXPECT_EQ(asked.lpm_k, 7) << "it changed together with the preset";
  const Correspondences input = message(250);
  const auto expect = [&](const std::string& spec, const core::OptionMap& options) {
    EXPECT_EQ(fromMsg(*selector.select(input, 0.0).selection).mask,
              core::createSelector(spec, options)->select(fromMsg(input)).mask);
  };
  expect("lpm:v2", {{"k", "7"}});

  asked.lpm_cost = standard.lpm_cost;  // back to the default: it counts beside the preset
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_EQ(asked.preset, "v2");
  EXPECT_EQ(asked.lpm_cost, standard.lpm_cost);
  expect("lpm:v2", {{"k", "7"}, {"cost", standard.lpm_cost}});

  asked.preset.clear();
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_EQ(asked.lpm_k, standard.lpm_k);
  EXPECT_EQ(asked.lpm_tau, standard.lpm_tau);
  expect("lpm", {});
}

TEST(LiveSelector, KeepsTheParametersOfOtherSelectors) {
  LiveSelector selector;
  SelectorConfig asked = config("lpm");
  asked.lpm_k = 9;
  ASSERT_EQ(selector.configure(asked).error, "");
  asked.selector = "gms";
  asked.preset = "rotation";
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_TRUE(asked.gms_rotation);
  asked.selector = "lpm";
  asked.preset.clear();
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_EQ(asked.lpm_k, 9);
  asked.selector = "gms";
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_FALSE(asked.gms_rotation) << "without preset again";
}

TEST(LiveSelector, FindsThePresetsOfAnEarlierStart) {
  LiveSelector before;
  SelectorConfig asked = config("lpm");
  asked.preset = "v2";
  asked.lpm_k = 9;
  ASSERT_EQ(before.configure(asked).error, "");
  EXPECT_EQ(before.presets(), "lpm:v2");

  SelectorConfig same = asked, other = asked;  // the parameters are found as they were
  ASSERT_EQ(LiveSelector(before.presets()).configure(same).error, "");
  EXPECT_EQ(same.lpm_k, 9);
  EXPECT_EQ(same.lpm_cost, "multiscale");
  other.preset.clear();
  ASSERT_EQ(LiveSelector(before.presets() + ",lpm:no_longer,nonsense").configure(other).error, "");
  EXPECT_EQ(other.lpm_cost, SelectorConfig::__getDefault__().lpm_cost);
  EXPECT_EQ(other.lpm_k, 9) << "it was not the preset's";
}

TEST(LiveSelector, OptionsWithoutAParameterAreAText) {
  LiveSelector selector;
  SelectorConfig asked = config("lpm");
  asked.options = "noise_floor=3,k=8";
  ASSERT_EQ(selector.configure(asked).error, "");
  EXPECT_EQ(asked.lpm_k, 8) << "it has a parameter";
  EXPECT_EQ(asked.options, "noise_floor=3");
  const Correspondences input = message(250);
  EXPECT_EQ(fromMsg(*selector.select(input, 0.0).selection).mask,
            core::createSelector("lpm", {{"k", "8"}, {"noise_floor", "3"}})->select(fromMsg(input)).mask);

  SelectorConfig bad = asked;
  bad.options = "noise_flor=3";
  EXPECT_NE(selector.configure(bad).error.find("noise_flor"), std::string::npos);
  EXPECT_EQ(bad.options, "noise_floor=3");

  asked.selector = "gms";
  const LiveSelector::Change change = selector.configure(asked);
  EXPECT_EQ(change.error, "");
  ASSERT_EQ(change.warnings.size(), 1u);
  EXPECT_NE(change.warnings[0].find("noise_floor=3"), std::string::npos);
  EXPECT_EQ(asked.options, "");
}

TEST(UnreadParameters, AreOptionsWithoutAParameter) {
  EXPECT_TRUE(unreadParameters({"selector", "gms_alpha", "lpm_nonsense", "presets_in_force"}).empty());
  const std::vector<std::string> complaints =
      unreadParameters({"vfc_beta", "plugin_options", "lap_lambda", "rfm_scan_scales"});
  ASSERT_EQ(complaints.size(), 4u);
  for (const std::string& text : complaints) EXPECT_NE(text.find("options"), std::string::npos) << text;
  EXPECT_NE(complaints[1].find("vfc_beta"), std::string::npos) << complaints[1];
  EXPECT_NE(complaints[2].find("'lambda=VALUE'"), std::string::npos) << complaints[2];
  EXPECT_NE(complaints[3].find("'scales=VALUE'"), std::string::npos) << complaints[3];
}

TEST(LiveSelector, TheStricterLimitCounts) {
  const Correspondences input = message(4000);
  for (const auto& [own, common] : {std::pair(1e-6, 5.0), std::pair(5.0, 1e-6), std::pair(0.0, 1e-6)}) {
    LiveSelector selector;
    SelectorConfig limited = config("ransac");
    limited.options = "max_seconds=" + core::formatNumber(own);
    limited.max_seconds = common;
    ASSERT_EQ(selector.configure(limited).error, "");
    const LiveSelector::Result result = selector.select(input, 0.0);
    EXPECT_NE(result.selection->status, Selection::STATUS_OK) << own << " " << common;
    EXPECT_NE(result.warning.find("max_seconds"), std::string::npos) << result.warning;
  }
}

TEST(LiveSelector, SaysWhenThereIsNothingToSelectAndWhenAMessageIsMalformed) {
  LiveSelector selector;
  SelectorConfig standard = config("gms");
  selector.configure(standard);
  Correspondences none = message(0);
  EXPECT_EQ(selector.select(none, 0.0).warning,
            "no putative matches: are the images dark, blurred or masked?");
  none.left_quality.black = none.right_quality.black = 0.93;
  none.right_quality.blur = 3;
  none.right_quality.texture = 0.25;
  const LiveSelector::Result dark = selector.select(none, 0.0);
  EXPECT_EQ(
      dark.warning,
      "no putative matches: the left image is dark: 93 % of the pixels are black; the right image is dark: "
      "93 % of the pixels are black, and is blurred: edges 3.0 px wide");
  EXPECT_EQ(dark.selection->left_quality.black, 0.93);
  EXPECT_EQ(dark.selection->right_quality.texture, 0.25);
  none.left_quality.black = none.right_quality.black = 0;
  none.header.stamp.fromSec(7.1);
  none.right_stamp.fromSec(7.0);
  const double angle = 8 * M_PI / 180;
  none.guess_rotation = {std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)};
  none.guess_sigma = 0.01;
  EXPECT_EQ(selector.select(none, 0.0).warning,
            "no putative matches: the right image is blurred: edges 3.0 px wide; turn of 80 deg/s");
  none.right_quality.blur = 0.7;
  EXPECT_EQ(
      selector.select(none, 0.0).warning,
      "no putative matches: the images are neither dark, overexposed, blurred nor noisy; are they masked?");
  Correspondences broken = message(20);
  broken.right_y.pop_back();
  EXPECT_THROW(selector.select(broken, 0.0), std::invalid_argument);
}

TEST(LiveSelector, ConfiguresWhileItSelects) {
  LiveSelector selector;
  SelectorConfig standard = config("gms");
  selector.configure(standard);
  std::atomic<bool> over{false};
  std::thread storm([&] {
    for (int i = 0; i < 200; ++i) {
      SelectorConfig next = config(i % 3 == 0 ? "lpm" : i % 3 == 1 ? "gms" : "nonsense");
      selector.configure(next);
    }
    over = true;
  });
  const Correspondences input = message(120);
  while (!over) {
    const LiveSelector::Result result = selector.select(input, 0.0);
    EXPECT_EQ(result.matches->left_x.size(), result.selection->n_selected);
  }
  storm.join();
}

}  // namespace
}  // namespace corrsel
