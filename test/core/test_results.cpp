#include <gtest/gtest.h>

#include <cmath>

#include "corrsel/benchmark/results.h"
#include "result_rows.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;
using testing::posesOf;
using testing::rowsOf;

TEST(Results, SummaryIsTheMeanOfPerPairValues) {
  std::vector<ResultRow> rows = rowsOf("1-2", 0.2), more = rowsOf("1-3", 0.8), none = rowsOf("1-4", 0.1);
  for (ResultRow& row : none) row.n_ground_truth = 0;
  std::vector<ResultRow> unsupported = rowsOf("1-5", 0.1);
  for (ResultRow& row : unsupported) row.status = Status::kUnsupportedInput;
  // A second repetition of the first pair counts within the pair, not as a pair.
  std::vector<ResultRow> again = rowsOf("1-2", 0.4);
  for (const auto* list : {&more, &none, &unsupported, &again})
    rows.insert(rows.end(), list->begin(), list->end());
  rows[0].metrics[0].precision = kUndefined;
  for (ResultRow& row : rows) row.confidence = row.selector == "gms" ? 7 : 0;
  rows[0].confidence = 3;
  const std::vector<SummaryRow> summary = summarize(rows);
  ASSERT_EQ(summary.size(), 4U);
  EXPECT_EQ(summary[0].selector, "gms");
  EXPECT_EQ(summary[0].tau, 5.0);
  EXPECT_EQ(summary[0].pairs, 2U);
  EXPECT_NEAR(summary[0].f_paper, (0.3 + 0.8) / 2, 1e-12);
  EXPECT_NEAR(summary[0].precision, (0.4 + 0.8) / 2, 1e-12);
  EXPECT_LE(summary[0].f_low, summary[0].f_paper);
  EXPECT_GE(summary[0].f_high, summary[0].f_paper);
  EXPECT_EQ(summary[0].confidence_median, 7);
  EXPECT_EQ(summary[2].confidence_median, 0);
  EXPECT_NEAR(summary[0].select_median, 0.001, 1e-12);
}

TEST(Results, PoseSummaryByHand) {
  std::vector<PoseRow> rows = posesOf("1-2", 2);
  const auto add = [&rows](const std::vector<PoseRow>& more) {
    rows.insert(rows.end(), more.begin(), more.end());
  };
  add(posesOf("1-3", 4));
  std::vector<PoseRow> failed = posesOf("1-4"), unsupported = posesOf("1-5");
  for (PoseRow& row : failed) {
    row.model = PoseModel::kNone;
    row.rotation_error = row.translation_error = kUndefined;
    row.pose_error = 180;
    row.epipolar_precision = 0;
  }
  for (PoseRow& row : unsupported) row.status = Status::kUnsupportedInput;
  add(failed);
  add(unsupported);
  const std::vector<PoseSummaryRow> summary = summarizePoses(rows);
  ASSERT_EQ(summary.size(), 3U);
  EXPECT_EQ(summary[2].selector, kGroundTruthSelection);
  const PoseSummaryRow& gms = summary[0];
  EXPECT_EQ(gms.selector, "gms");
  EXPECT_EQ(gms.poses, 3U);
  EXPECT_EQ(gms.no_pose, 1U);
  EXPECT_EQ(gms.homographies, 0U);
  // To 2: a triangle of height 1/3. From 2 to 4: the mean of 1/3 and 2/3. Then 2/3.
  EXPECT_NEAR(gms.auc_5, (1.0 / 3 + 1 + 2.0 / 3) / 5, 1e-12);
  EXPECT_NEAR(gms.auc_10, (1.0 / 3 + 1 + 4) / 10, 1e-12);
  EXPECT_LE(gms.auc_10_low, gms.auc_10);
  EXPECT_GE(gms.auc_10_high, gms.auc_10);
  EXPECT_NEAR(gms.accuracy, (0.8 + 0.6 + 0) / 3, 1e-12);
  EXPECT_EQ(gms.rotation_median, 3);
  EXPECT_EQ(gms.translation_median, 1.5);
  EXPECT_EQ(gms.pose_median, 4);
  EXPECT_NEAR(gms.epipolar_precision, 1.0 / 3, 1e-12);
  EXPECT_TRUE(std::isnan(gms.corner_auc_3));
}

OwnPose ownPose(Motion motion, double error, double nees, std::size_t degrees) {
  OwnPose own;
  own.motion = motion;
  own.true_motion = Motion::kGeneral;
  own.pose_error = motion == Motion::kNone ? 180 : error;
  if (motion != Motion::kNone) own.rotation_error = error;
  own.normalized = {nees, degrees};
  return own;
}

TEST(Results, SummaryOfOwnPosesByHand) {
  std::vector<PoseRow> rows;
  const auto add = [&rows](const OwnPose& own) {
    PoseRow row = posesOf("1-" + std::to_string(rows.size() + 2))[0];
    row.own = own;
    rows.push_back(row);
  };
  add(ownPose(Motion::kGeneral, 2, 4, 5));
  add(ownPose(Motion::kGeneral, 4, 12, 5));
  add(ownPose(Motion::kNone, 0, kUndefined, 0));
  OwnPose plane = ownPose(Motion::kPlanar, 1, 1000, 5);
  plane.second_error = 0.5;
  add(plane);
  add(ownPose(Motion::kRotation, 0.5, 1, 3));
  OwnPose uncertain = ownPose(Motion::kGeneral, 3, kUndefined, 0);
  uncertain.uncertain = true;
  add(uncertain);
  rows.push_back(posesOf("1-9")[0]);  // without a pose of its own
  const std::vector<PoseSummaryRow> summary = summarizePoses(rows);
  ASSERT_EQ(summary.size(), 1U);
  EXPECT_EQ(summary[0].poses, 7U);
  const OwnPoseSummary& own = summary[0].own;
  EXPECT_EQ(own.poses, 6U);
  EXPECT_EQ(own.no_pose, 1U);
  EXPECT_EQ(own.uncertain, 1U);
  EXPECT_NEAR(own.auc_10, errorAuc({0.5, 1, 2, 3, 4, 180}, 10), 1e-12);
  EXPECT_LE(own.auc_10_low, own.auc_10);
  EXPECT_GE(own.auc_10_high, own.auc_10);
  EXPECT_EQ(own.rotation_median, 2);
  EXPECT_TRUE(std::isnan(own.translation_median));
  EXPECT_EQ(own.pose_median, 2.5);
  EXPECT_EQ(own.with_translation.poses, 2U);  // not the plane
  EXPECT_EQ(own.with_translation.mean, 8);
  EXPECT_EQ(own.with_translation.inside, 0.5);
  EXPECT_EQ(own.rotations.poses, 1U);
  EXPECT_EQ(own.rotations.median, 1);
  EXPECT_EQ(own.rotations.inside, 1);
}

TEST(Results, CornersOfFailedHomographiesAreInfinite) {
  std::vector<PoseRow> rows;
  for (const auto& [pair, error] : {std::pair{"a", 0.5}, {"b", 2.0}, {"c", INFINITY}}) {
    PoseRow row = posesOf(pair)[0];
    row.model = PoseModel::kNone;
    row.n_inliers = 0;
    row.rotation_error = row.translation_error = row.pose_error = row.epipolar_precision = kUndefined;
    row.corner_error = error;
    rows.push_back(row);
  }
  const std::vector<PoseSummaryRow> summary = summarizePoses(rows);
  ASSERT_EQ(summary.size(), 1U);
  EXPECT_EQ(summary[0].poses, 0U);
  EXPECT_EQ(summary[0].no_pose, 0U);
  EXPECT_EQ(summary[0].homographies, 3U);
  EXPECT_EQ(summary[0].no_homography, 1U);
  EXPECT_NEAR(summary[0].corner_auc_1, 0.5 * (1.0 / 6) + 0.5 * (1.0 / 3), 1e-12);
  EXPECT_EQ(summary[0].corner_median, 2);
  EXPECT_TRUE(std::isnan(summary[0].pose_median));
}

}  // namespace
}  // namespace corrsel::core
