#include <gtest/gtest.h>

#include "search/sprt.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// A of the fixed point A = K + ln A.
double decision(double epsilon, double delta, double model_time, double models) {
  const double c = (1 - delta) * std::log((1 - delta) / (1 - epsilon)) + delta * std::log(delta / epsilon);
  const double k = model_time * c / models + 1;
  double a = k;
  for (int i = 0; i < 100; ++i) a = k + std::log(a);
  return a;
}

TEST(Sprt, DecisionIsTheFixedPoint) {
  EXPECT_NEAR(1 / Sprt({0.2, 0.05, 200, 2.38}).loss(), decision(0.2, 0.05, 200, 2.38), 1e-6);
  EXPECT_NEAR(1 / Sprt({0.2, 0.05, 200, 2.38}).loss(), 11.3, 0.1);  // USAC 1.0
  EXPECT_NEAR(1 / Sprt({0.05, 0.005, 1000, 1}).loss(), decision(0.05, 0.005, 1000, 1), 1e-6);
}

TEST(Sprt, NeverLosesMoreThanOneRightModelInEight) {
  // OpenCV's first design: A = 1.24 by the formula.
  EXPECT_LE(decision(0.01, 0.008, 150, 1), 1.3);
  EXPECT_EQ(Sprt({0.01, 0.008, 150, 1}).loss(), 1.0 / 8);
  // delta as large as epsilon is no test at all: it is kept below half of it.
  EXPECT_LE(Sprt({0.1, 0.4, 100, 1}).loss(), 1.0 / 8);
}

TEST(Sprt, RuleHoldsTheLogarithms) {
  ScoreRule rule{};
  const Sprt sprt({0.2, 0.05, 200, 2.38});
  sprt.apply(rule);
  EXPECT_NEAR(rule.log_consistent, std::log(0.05 / 0.2), 1e-12);
  EXPECT_NEAR(rule.log_inconsistent, std::log(0.95 / 0.8), 1e-12);
  EXPECT_NEAR(rule.log_decision, std::log(1 / sprt.loss()), 1e-12);
}

TEST(Sprt, LearnsDeltaFromRejectedModels) {
  Sprt sprt({0.2, 0.05, 200, 2.38});
  ModelScore rejected;
  rejected.seen = 50;
  rejected.inliers = 1;
  int designs = 0;
  for (int i = 0; i < 49; ++i) designs += sprt.addRejected(rejected);
  EXPECT_EQ(designs, 0);  // too few to tell
  for (int i = 0; i < 500; ++i) designs += sprt.addRejected(rejected);
  EXPECT_EQ(designs, 1);  // 0.02 once, nothing new after that
  ScoreRule rule{};
  sprt.apply(rule);
  EXPECT_NEAR(rule.log_consistent, std::log(0.02 / 0.2), 1e-12);
}

TEST(Sprt, EpsilonRisesWithTheBestModelOnly) {
  Sprt sprt({0.2, 0.05, 200, 2.38});
  EXPECT_FALSE(sprt.addBest(0.1));
  EXPECT_TRUE(sprt.addBest(0.5));
  EXPECT_FALSE(sprt.addBest(0.4));
  ScoreRule rule{};
  sprt.apply(rule);
  EXPECT_NEAR(rule.log_consistent, std::log(0.05 / 0.5), 1e-12);
  EXPECT_TRUE(sprt.addBest(1.0));  // all agree: the logarithms stay finite
  sprt.apply(rule);
  EXPECT_TRUE(std::isfinite(rule.log_inconsistent) && std::isfinite(rule.log_decision));
}

/// Share of rejected models, each agreeing with a match with the given probability.
double rejectedShare(double agreement, const ScoreRule& rule) {
  Random random(9);
  int rejected = 0;
  constexpr int kModels = 4000;
  for (int model = 0; model < kModels; ++model) {
    double log_ratio = 0;
    for (std::size_t seen = 0; seen < 2000; seen += ScoreRule::kBlock) {
      for (std::size_t i = 0; i < ScoreRule::kBlock; ++i)
        log_ratio += random.uniform() < agreement ? rule.log_consistent : rule.log_inconsistent;
      if (log_ratio > rule.log_decision) {
        ++rejected;
        break;
      }
    }
  }
  return double(rejected) / kModels;
}

TEST(Sprt, LossBoundsTheRightModelsItRejects) {
  for (const SprtConstants& constants : {SprtConstants{0.05, 0.005, 1000, 1}, {0.15, 0.05, 2500, 2.38}}) {
    const Sprt sprt(constants);
    ScoreRule rule{};
    sprt.apply(rule);
    EXPECT_LE(rejectedShare(constants.epsilon, rule), sprt.loss());
    EXPECT_GT(rejectedShare(constants.delta, rule), 0.99);
  }
}

}  // namespace
}  // namespace corrsel::core
