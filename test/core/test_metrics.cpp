#include <gtest/gtest.h>

#include "corrsel/evaluation/metrics.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kInf = std::numeric_limits<double>::infinity();

EvaluationOptions at(std::vector<double> tolerances, double ground_truth_tolerance = 10) {
  return {std::move(tolerances), ground_truth_tolerance};
}

TEST(Metrics, TenMatchesByHand) {
  // match              0    1  2    3  4   5     6   7     8     9
  const std::vector<double> errors = {0.5, 2, 5, 5.5, 9, 10, 10.5, 80, kInf, 1};
  const std::vector<std::uint8_t> mask = {1, 1, 1, 1, 0, 0, 1, 1, 0, 0};
  const Evaluation e = evaluate(TruthKind::kHomography, errors, mask, at({1, 5, 10}));
  EXPECT_EQ(e.n_putative, 10u);
  EXPECT_EQ(e.n_ground_truth, 7u);  // 0 1 2 3 4 5 9: the tolerance itself counts
  EXPECT_EQ(e.n_selected, 6u);
  ASSERT_EQ(e.metrics.size(), 3u);

  // tau 1: right are 0 and 9, selected of them 0.
  EXPECT_EQ(e.metrics[0].tau, 1);
  EXPECT_EQ(e.metrics[0].n_correct, 1u);
  EXPECT_DOUBLE_EQ(e.metrics[0].precision, 1.0 / 6);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_paper, 1.0 / 7);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_same_tau, 1.0 / 2);
  EXPECT_DOUBLE_EQ(e.metrics[0].f_paper, 2.0 / 13);
  EXPECT_DOUBLE_EQ(e.metrics[0].f_same_tau, 2.0 / 8);

  // tau 5: right are 0 1 2 9, selected 0 1 2.
  EXPECT_EQ(e.metrics[1].n_correct, 3u);
  EXPECT_DOUBLE_EQ(e.metrics[1].precision, 3.0 / 6);
  EXPECT_DOUBLE_EQ(e.metrics[1].recall_paper, 3.0 / 7);
  EXPECT_DOUBLE_EQ(e.metrics[1].recall_same_tau, 3.0 / 4);
  EXPECT_DOUBLE_EQ(e.metrics[1].f_paper, 6.0 / 13);
  EXPECT_DOUBLE_EQ(e.metrics[1].f_same_tau, 6.0 / 10);

  // tau 10: both recalls are one.
  EXPECT_EQ(e.metrics[2].n_correct, 4u);
  EXPECT_DOUBLE_EQ(e.metrics[2].recall_paper, 4.0 / 7);
  EXPECT_DOUBLE_EQ(e.metrics[2].recall_same_tau, 4.0 / 7);
}

/// Everything worked out by hand, from coordinates to F: the right image is the left one moved by (10, -20)
/// px.
TEST(Metrics, TenWrittenDownMatchesByHand) {
  GroundTruth truth;
  truth.kind = TruthKind::kHomography;
  truth.matrix = cv::Matx33d(1, 0, 10, 0, 1, -20, 0, 0, 1);
  Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  matches.add({100, 100}, {110, 80});   // 0: error 0
  matches.add({200, 100}, {213, 84});   // 1: 5 (3, 4)
  matches.add({300, 100}, {310, 86});   // 2: 6
  matches.add({400, 100}, {416, 88});   // 3: 10 (6, 8)
  matches.add({100, 200}, {119, 192});  // 4: 15 (9, 12)
  matches.add({200, 200}, {211, 180});  // 5: 1
  matches.add({300, 200}, {310, 184});  // 6: 4
  matches.add({400, 200}, {50, 400});   // 7: far
  matches.add({100, 300}, {122, 285});  // 8: 13 (12, 5)
  matches.add({200, 300}, {212, 280});  // 9: 2
  const std::vector<std::uint8_t> selected = {1, 1, 1, 0, 1, 1, 0, 0, 0, 0};
  const std::vector<double> errors = groundTruthErrors(truth, matches);
  const std::vector<double> by_hand = {0, 5, 6, 10, 15, 1, 4, std::hypot(360, -220), 13, 2};
  for (std::size_t i = 0; i < 10; ++i) EXPECT_DOUBLE_EQ(errors[i], by_hand[i]) << i;

  // Ground-truth inliers, error at most 10: 0 1 2 3 5 6 9. Within 5: 0 1 5 6 9. Selected and within 5: 0 1 5.
  const Evaluation e = evaluate(truth.kind, errors, selected, at({5}));
  EXPECT_EQ(e.n_putative, 10u);
  EXPECT_EQ(e.n_ground_truth, 7u);
  EXPECT_EQ(e.n_selected, 5u);
  const Metrics& m = e.metrics.at(0);
  EXPECT_EQ(m.n_correct, 3u);
  EXPECT_DOUBLE_EQ(m.precision, 3.0 / 5);
  EXPECT_DOUBLE_EQ(m.recall_paper, 3.0 / 7);
  EXPECT_DOUBLE_EQ(m.f_paper, 0.5);  // 2 * 3/5 * 3/7 / (3/5 + 3/7) = (18/35) / (36/35)
  EXPECT_DOUBLE_EQ(m.recall_same_tau, 3.0 / 5);
  EXPECT_DOUBLE_EQ(m.f_same_tau, 3.0 / 5);
}

TEST(Metrics, DefaultsAreThoseOfThePaper) {
  const Evaluation e = evaluate(TruthKind::kHomography, {10, 10.1}, {1, 1});
  ASSERT_EQ(e.metrics.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(e.metrics[i].tau, double(i + 1));
  EXPECT_EQ(e.n_ground_truth, 1u);
}

TEST(Metrics, GroundTruthToleranceIsIndependentOfTau) {
  const Evaluation e = evaluate(TruthKind::kHomography, {1, 3, 4, 8}, {1, 1, 1, 1}, at({4}, 2));
  EXPECT_EQ(e.n_ground_truth, 1u);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_paper, 3);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_same_tau, 1);
}

TEST(Metrics, NothingSelected) {
  const Metrics m = evaluate(TruthKind::kHomography, {1, 50}, {0, 0}, at({5})).metrics[0];
  EXPECT_TRUE(std::isnan(m.precision));
  EXPECT_EQ(m.recall_paper, 0);
  EXPECT_EQ(m.recall_same_tau, 0);
  EXPECT_EQ(m.f_paper, 0);
  EXPECT_EQ(m.f_same_tau, 0);
}

TEST(Metrics, OnlyWrongOnesSelected) {
  const Metrics m = evaluate(TruthKind::kHomography, {1, 50}, {0, 1}, at({5})).metrics[0];
  EXPECT_EQ(m.precision, 0);
  EXPECT_EQ(m.f_paper, 0);
  EXPECT_EQ(m.f_same_tau, 0);
}

TEST(Metrics, NoInlier) {
  const Evaluation e = evaluate(TruthKind::kHomography, {50, kInf}, {1, 0}, at({5}));
  EXPECT_EQ(e.n_ground_truth, 0u);
  EXPECT_EQ(e.metrics[0].precision, 0);
  EXPECT_TRUE(std::isnan(e.metrics[0].recall_paper));
  EXPECT_TRUE(std::isnan(e.metrics[0].recall_same_tau));
  EXPECT_TRUE(std::isnan(e.metrics[0].f_paper));
  EXPECT_TRUE(std::isnan(e.metrics[0].f_same_tau));
  // An inlier at 10 px but none at tau.
  const Metrics m = evaluate(TruthKind::kHomography, {8}, {1}, at({5})).metrics[0];
  EXPECT_EQ(m.recall_paper, 0);
  EXPECT_EQ(m.f_paper, 0);
  EXPECT_TRUE(std::isnan(m.recall_same_tau));
  EXPECT_TRUE(std::isnan(m.f_same_tau));
}

TEST(Metrics, UnknownTruthTakesNoPart) {
  const Evaluation e =
      evaluate(TruthKind::kDisparity, {1, kUndefined, kUndefined, 50}, {1, 1, 0, 1}, at({5}));
  EXPECT_EQ(e.n_putative, 2u);
  EXPECT_EQ(e.n_selected, 2u);
  EXPECT_EQ(e.n_ground_truth, 1u);
  EXPECT_DOUBLE_EQ(e.metrics[0].precision, 0.5);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_paper, 1);
}

TEST(Metrics, WithoutAnyTruthMatchesAreCountedOnly) {
  const double nan = kUndefined;
  const Evaluation result = evaluate(TruthKind::kNone, {nan, nan, nan}, {1, 0, 1});
  EXPECT_EQ(result.n_putative, 3U);
  EXPECT_EQ(result.n_selected, 2U);
  EXPECT_EQ(result.n_ground_truth, 0U);
  ASSERT_EQ(result.metrics.size(), 10U);
  EXPECT_EQ(result.metrics[4].tau, 5);
  EXPECT_EQ(result.metrics[4].n_correct, 0U);
  EXPECT_TRUE(std::isnan(result.metrics[4].precision));
  EXPECT_TRUE(std::isnan(result.metrics[4].recall_paper));
  EXPECT_TRUE(std::isnan(result.metrics[4].f_paper));
}

TEST(Metrics, LabelsHaveOneRowWithoutTolerance) {
  const Evaluation e = evaluate(TruthKind::kLabels, {0, 0, 0, kInf, kInf}, {1, 1, 0, 1, 0});
  EXPECT_EQ(e.n_putative, 5u);
  EXPECT_EQ(e.n_ground_truth, 3u);
  ASSERT_EQ(e.metrics.size(), 1u);
  EXPECT_TRUE(std::isnan(e.metrics[0].tau));
  EXPECT_EQ(e.metrics[0].n_correct, 2u);
  EXPECT_DOUBLE_EQ(e.metrics[0].precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_paper, 2.0 / 3);
  EXPECT_DOUBLE_EQ(e.metrics[0].recall_same_tau, 2.0 / 3);
  EXPECT_DOUBLE_EQ(e.metrics[0].f_paper, 2.0 / 3);
}

TEST(Metrics, EmptyInput) {
  const Evaluation e = evaluate(TruthKind::kHomography, {}, {}, at({5}));
  EXPECT_EQ(e.n_putative + e.n_selected + e.n_ground_truth, 0u);
  EXPECT_TRUE(std::isnan(e.metrics[0].precision) && std::isnan(e.metrics[0].f_paper));
  EXPECT_TRUE(evaluate(TruthKind::kHomography, {1}, {1}, at({})).metrics.empty());
}

TEST(Metrics, RefusesAMaskOfAnotherLength) {
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] {
                         evaluate(TruthKind::kHomography, {1, 2}, {1});
                       }),
                       {"1 elements", "2 matches"}));
}

}  // namespace
}  // namespace corrsel::core
