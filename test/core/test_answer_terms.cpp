#include <gtest/gtest.h>

#include <numeric>

#include "geometry/residual.h"
#include "posterior/answer_terms.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

// Positions of the terms.
enum Term : std::size_t {
  kConstant,
  kFundamental,
  kNear,
  kLocal,
  kNearLocal,
  kDoubt,
  kNearDoubt,
  kRatio,
  kPurity,
  kLeftOver,
  kOtherMotion
};

/// A plane, and what `auto` would know about it.
class PlaneTerms : public ::testing::Test {
 protected:
  PlaneTerms() : scene_(homographyScene({600, 0.5, 0.5, 3})) {
    addFrames(scene_);
    std::vector<std::uint32_t> order(scene_.matches.size());
    std::iota(order.begin(), order.end(), 0U);
    support_.compute(scene_.matches, order);
    errors_.resize(scene_.matches.size());
    pixelErrors(Residual::kSmallerTransfer, scene_.model, scene_.matches, errors_.data());
  }

  AnsweredMatches answered(ModelKind kind = ModelKind::kHomography) const {
    return {scene_.matches, support_, scene_.inlier, kind, scene_.model, 30};
  }

  Scene scene_;
  LocalSupport support_;
  std::vector<double> errors_;
};

TEST_F(PlaneTerms, HaveTheValuesOfTheirDefinition) {
  errors_[0] = 0;
  errors_[1] = 25;
  errors_[2] = 225;
  errors_[3] = std::numeric_limits<double>::infinity();
  errors_[4] = std::numeric_limits<double>::quiet_NaN();
  const AnsweredMatches answer = answered();
  const AnswerTerms terms(answer, errors_);
  const double near[] = {1, 0, -0.8, -1, -1};
  for (std::size_t i = 0; i < 5; ++i) {
    const ProbabilityTerms t = terms.of(i);
    const double local = support_.extended()[i];
    EXPECT_EQ(t[kConstant], 1);
    EXPECT_EQ(t[kFundamental], 0);
    EXPECT_NEAR(t[kNear], near[i], 1e-9) << i;
    EXPECT_EQ(t[kLocal], local);
    EXPECT_EQ(t[kNearLocal], t[kNear] * local);
    EXPECT_DOUBLE_EQ(t[kDoubt], 0.25);
    EXPECT_DOUBLE_EQ(t[kNearDoubt], t[kNear] / 4);
    EXPECT_EQ(t[kPurity] == 0, local > 0) << i;
    EXPECT_NEAR(t[kOtherMotion], scene_.inlier[i] * std::pow((1 - near[i]) / 2, 2), 1e-9) << i;
    const double off = std::pow((1 - near[i]) / 2, 2);
    EXPECT_TRUE(local > 0 ? t[kLeftOver] >= 0 && t[kLeftOver] <= off : t[kLeftOver] == 0) << t[kLeftOver];
  }
}

TEST_F(PlaneTerms, TakeTheRatioWhereItIsKnown) {
  Correspondences& m = scene_.matches;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float distance[] = {60, 10, 95, 0, 50}, second[] = {100, 100, 0, 0, nan};
  const double expected[] = {-0.2, -0.3, 0.2, 0, 0};
  for (std::size_t i = 0; i < 5; ++i) {
    m.distance[i] = distance[i];
    m.second_distance[i] = second[i];
  }
  const AnsweredMatches answer = answered();
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(AnswerTerms(answer, errors_).of(i)[kRatio], expected[i], 1e-6) << i;
  m.second_distance.clear();
  EXPECT_EQ(AnswerTerms(answer, errors_).of(0)[kRatio], 0);
}

TEST_F(PlaneTerms, TellWhatTheModelLeavesOverAndWhatAgreesByChance) {
  ASSERT_GT(support_.localSize(), 200u);
  const AnsweredMatches answer = answered();
  const auto member = static_cast<std::size_t>(
      std::find(support_.extended().begin(), support_.extended().end(), 1) - support_.extended().begin());
  const auto other = static_cast<std::size_t>(
      std::find(support_.extended().begin(), support_.extended().end(), 0) - support_.extended().begin());
  const ProbabilityTerms explained = AnswerTerms(answer, errors_).of(member);
  const ProbabilityTerms by_chance = AnswerTerms(answer, errors_).of(other);
  EXPECT_LT(by_chance[kPurity], 1);
  const std::vector<double> far(errors_.size(), 1e6), near(errors_.size(), 1);
  EXPECT_GT(AnswerTerms(answer, far).of(member)[kLeftOver], explained[kLeftOver] + 0.5);
  EXPECT_EQ(AnswerTerms(answer, near).of(other)[kPurity], 2);
  EXPECT_EQ(AnswerTerms(answer, near).farOthers(), 0u);
}

TEST_F(PlaneTerms, WithoutAModelAreSupportRatioAndDoubt) {
  const AnsweredMatches answer = answered(ModelKind::kNone);
  const std::vector<double> none;
  const ProbabilityTerms t = AnswerTerms(answer, none).of(0);
  for (const Term term : {kFundamental, kNear, kNearLocal, kNearDoubt, kPurity, kLeftOver, kOtherMotion})
    EXPECT_EQ(t[term], 0) << term;
  EXPECT_EQ(t[kLocal], support_.extended()[0]);
  EXPECT_DOUBLE_EQ(t[kDoubt], 0.25);
  EXPECT_NE(t[kRatio], 0);
}

}  // namespace
}  // namespace corrsel::core
