#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>

#include "search/significance.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::homographyScene;
using testing::Scene;
using Mask = std::vector<std::uint8_t>;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// A selector whose behaviour the test defines.
class Stub : public Selector {
 public:
  using Run = std::function<void(const Correspondences&, Selection&)>;
  explicit Stub(Run run, bool needs_distance = false)
      : run_(std::move(run)), needs_distance_(needs_distance) {}
  std::string name() const override { return "stub"; }
  const OptionSet& options() const override { return options_; }

 protected:
  std::string missingInput(const Correspondences& matches) const override {
    return needs_distance_ && matches.distance.empty() ? "stub needs the column distance" : "";
  }
  void run(const Correspondences& matches, Workspace&, Selection& result) const override {
    run_(matches, result);
  }

 private:
  Run run_;
  bool needs_distance_;
  NoOptions options_;
};

Correspondences matches(std::size_t n) {
  Correspondences m;
  for (std::size_t i = 0; i < n; ++i) m.add({float(i), float(i + 100)}, {float(i + 200), float(i + 300)});
  return m;
}

/// Selects matches with an even left x; the score is the left x, the distance must be ten times it.
void selectEven(const Correspondences& m, Selection& result) {
  ASSERT_EQ(result.mask, Mask(m.size(), 0));
  result.score.resize(m.size());
  for (std::size_t i = 0; i < m.size(); ++i) {
    result.mask[i] = int(m.left_x[i]) % 2 == 0;
    result.score[i] = m.left_x[i];
    if (!m.distance.empty()) {
      EXPECT_EQ(m.distance[i], 10 * m.left_x[i]);
    }
  }
  result.status = Status::kTimeLimit;
  result.message = "half";
  result.iterations = 5;
  result.confidence = 2.5;
  result.sigma = 0.75;
  for (const float x : m.left_x) result.probability.push_back((x + 1) / 16);
  result.model_kind = ModelKind::kHomography;
  result.model(0, 2) = 7;
}

TEST(Selector, HandsOverTheAnswer) {
  const Selection s = Stub(selectEven).select(matches(5));
  EXPECT_EQ(s.mask, (Mask{1, 0, 1, 0, 1}));
  EXPECT_EQ(s.score, (std::vector<float>{0, 1, 2, 3, 4}));
  EXPECT_EQ(s.status, Status::kTimeLimit);
  EXPECT_EQ(s.message, "half");
  EXPECT_EQ(s.iterations, 5);
  EXPECT_EQ(s.confidence, 2.5);
  EXPECT_EQ(s.sigma, 0.75);
  EXPECT_EQ(s.probability, (std::vector<float>{1 / 16.0F, 2 / 16.0F, 3 / 16.0F, 4 / 16.0F, 5 / 16.0F}));
  EXPECT_EQ(s.model_kind, ModelKind::kHomography);
  EXPECT_EQ(s.model(0, 2), 7);
  EXPECT_EQ(s.n_input, 5u);
  EXPECT_EQ(s.n_ignored, 0u);
  EXPECT_EQ(s.n_selected, 3u);
  EXPECT_GT(s.seconds, 0);
  EXPECT_LT(s.seconds, 1);
}

TEST(Selector, SetsUnusableRowsAside) {
  for (const float bad : {kNaN, kInf, -kInf, 1000001.0f, -1000001.0f}) {
    using Column = std::vector<float> Correspondences::*;
    for (const Column column : {&Correspondences::left_x, &Correspondences::left_y, &Correspondences::right_x,
                                &Correspondences::right_y}) {
      Correspondences m = matches(6);
      m.distance = {0, 10, 20, 30, 40, 50};
      (m.*column)[0] = (m.*column)[4] = bad;
      const Selection s = Stub(selectEven).select(m);
      EXPECT_EQ(s.mask, (Mask{0, 0, 1, 0, 0, 0})) << bad;
      ASSERT_EQ(s.score.size(), 6u);
      for (std::size_t i : {1, 2, 3, 5}) EXPECT_EQ(s.score[i], float(i));
      EXPECT_TRUE(std::isnan(s.score[0]) && std::isnan(s.score[4]));
      EXPECT_EQ(s.n_input, 6u);
      EXPECT_EQ(s.n_ignored, 2u);
      EXPECT_EQ(s.n_selected, 1u);
      EXPECT_EQ(s.status, Status::kTimeLimit);
      EXPECT_EQ(s.message, "half");
      EXPECT_EQ(s.iterations, 5);
      EXPECT_EQ(s.confidence, 2.5);
      EXPECT_EQ(s.sigma, 0.75);
      EXPECT_EQ(s.probability, (std::vector<float>{0, 2 / 16.0F, 3 / 16.0F, 4 / 16.0F, 0, 6 / 16.0F}));
      EXPECT_EQ(s.model_kind, ModelKind::kHomography);
      EXPECT_EQ(s.model(0, 2), 7);
    }
  }
}

TEST(Selector, KeepsTheLargestUsableCoordinates) {
  Correspondences m = matches(3);
  m.left_y = {1e6f, -1e6f, 0};
  EXPECT_EQ(Stub(selectEven).select(m).n_ignored, 0u);
}

TEST(Selector, GivesNoScoreWhereTheMethodGivesNone) {
  Correspondences m = matches(3);
  m.right_y[1] = kNaN;
  const Selection s = Stub([](const Correspondences&, Selection& result) { result.mask[1] = 1; }).select(m);
  EXPECT_EQ(s.mask, (Mask{0, 0, 1}));
  EXPECT_TRUE(s.score.empty());
}

TEST(Selector, RunsOnEmptyInput) {
  bool ran = false;
  const Stub stub([&ran](const Correspondences& m, Selection&) { ran = m.empty(); });
  EXPECT_EQ(stub.select({}).status, Status::kOk);
  EXPECT_TRUE(ran);
  Correspondences bad = matches(2);
  bad.left_x = {kNaN, kNaN};
  ran = false;
  const Selection s = stub.select(bad);
  EXPECT_TRUE(ran);
  EXPECT_EQ(s.mask, Mask(2, 0));
  EXPECT_EQ(s.n_ignored, 2u);
}

TEST(Selector, AnswersMissingAndInconsistentColumns) {
  bool ran = false;
  const Stub stub([&ran](const Correspondences&, Selection&) { ran = true; }, true);
  Selection s = stub.select(matches(3));
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_EQ(s.message, "stub needs the column distance");
  EXPECT_EQ(s.mask, Mask(3, 0));

  Correspondences m = matches(3);
  m.distance = {1, 2};
  s = stub.select(m);
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_EQ(s.message, "column distance has 2 elements, left_x has 3");
  m = matches(3);
  m.left_y.pop_back();
  m.distance = {1, 2, 3};
  s = stub.select(m);
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_EQ(s.mask, Mask(3, 0));
  EXPECT_EQ(s.n_input, 3u);
  EXPECT_FALSE(ran);
}

TEST(Selector, RefusesAnswersOfAnotherLength) {
  for (const bool with_bad_row : {false, true}) {
    Correspondences m = matches(3);
    if (with_bad_row) m.left_x[1] = kNaN;
    const Selection mask = Stub([](const Correspondences&, Selection& r) { r.mask.assign(9, 1); }).select(m);
    const Selection score =
        Stub([](const Correspondences&, Selection& r) { r.score.assign(1, 1); }).select(m);
    for (const Selection& s : {mask, score}) {
      EXPECT_EQ(s.status, Status::kFailed);
      EXPECT_EQ(s.mask, Mask(3, 0));
      EXPECT_TRUE(s.score.empty());
    }
  }
}

TEST(Selector, TurnsExceptionsIntoStatuses) {
  for (const bool with_bad_row : {false, true}) {
    Correspondences m = matches(3);
    if (with_bad_row) m.left_x[1] = kNaN;
    const auto spoil = [](Selection& result) {
      result.mask[0] = 1;
      result.score = {1};
      result.model_kind = ModelKind::kFundamental;
    };
    const Selection failed = Stub([&spoil](const Correspondences&, Selection& result) {
                               spoil(result);
                               throw std::runtime_error("division by zero");
                             }).select(m);
    EXPECT_EQ(failed.status, Status::kFailed);
    EXPECT_EQ(failed.message, "division by zero");
    const Selection large = Stub([&spoil](const Correspondences&, Selection& result) {
                              spoil(result);
                              throw std::bad_alloc();
                            }).select(m);
    EXPECT_EQ(large.status, Status::kTooLarge);
    EXPECT_EQ(large.message, "out of memory with 3 matches");
    for (const Selection& s : {failed, large}) {
      EXPECT_EQ(s.mask, Mask(3, 0));
      EXPECT_TRUE(s.score.empty());
      EXPECT_EQ(s.model_kind, ModelKind::kNone);
      EXPECT_EQ(s.n_input, 3u);
      EXPECT_EQ(s.n_selected, 0u);
    }
  }
}

TEST(Selector, RefusesNonsense) {
  const struct {
    Stub::Run run;
    const char* message;
  } cases[] = {
      {[](const Correspondences&, Selection& r) { r.mask[1] = 255; },
       "the selector returned a mask that holds 255; allowed are 0 and 1"},
      {[](const Correspondences&, Selection& r) { r.status = static_cast<Status>(9); },
       "the selector returned a status or a kind of model that does not exist: 9, 0"},
      {[](const Correspondences&, Selection& r) { r.model_kind = static_cast<ModelKind>(5); },
       "the selector returned a status or a kind of model that does not exist: 0, 5"},
      {[](const Correspondences&, Selection& r) {
         r.model_kind = ModelKind::kHomography;
         r.model(2, 1) = std::numeric_limits<double>::quiet_NaN();
       },
       "the selector returned a model that is not finite"},
      {[](const Correspondences&, Selection& r) { r.scene = static_cast<SceneKind>(6); },
       "the selector returned a scene that does not exist: 6"},
      {[](const Correspondences&, Selection& r) { r.confidence = -1; },
       "the selector returned a confidence of -1; allowed are finite numbers from 0, and NaN where it is not "
       "computed"},
      {[](const Correspondences&, Selection& r) { r.confidence = std::numeric_limits<double>::infinity(); },
       "the selector returned a confidence of inf; allowed are finite numbers from 0, and NaN where it is "
       "not computed"},
      {[](const Correspondences&, Selection& r) { r.sigma = -1; },
       "the selector returned a sigma of -1; allowed are finite numbers from 0, and NaN where it is not "
       "computed"},
      {[](const Correspondences&, Selection& r) { r.probability.assign(r.mask.size(), 1.5F); },
       "the selector returned the probability 1.500000; allowed are 0 to 1"},
      {[](const Correspondences&, Selection& r) { r.probability.assign(r.mask.size(), kNaN); },
       "the selector returned the probability nan; allowed are 0 to 1"},
      {[](const Correspondences&, Selection& r) { r.group.assign(r.mask.size(), -2); },
       "the selector returned the group number -2 for a match with mask 0; allowed are numbers from 0 for "
       "selected matches, and -1"},
      {[](const Correspondences&, Selection& r) { r.group.assign(r.mask.size(), 1); },
       "the selector returned the group number 1 for a match with mask 0; allowed are numbers from 0 for "
       "selected matches, and -1"},
      {[](const Correspondences&, Selection&) { throw 7; },
       "the selector threw something that is not a std::exception"},
  };
  for (const bool with_bad_row : {false, true}) {
    Correspondences m = matches(3);
    if (with_bad_row) m.left_x[1] = kNaN;
    for (const auto& c : cases) {
      const Selection s = Stub(c.run).select(m);
      EXPECT_EQ(s.status, Status::kFailed);
      EXPECT_EQ(s.message, c.message);
      EXPECT_EQ(s.mask, Mask(3, 0));
      EXPECT_EQ(s.model_kind, ModelKind::kNone);
      EXPECT_EQ(s.n_selected, 0u);
    }
  }
}

TEST(Selector, UnusableRowsHaveNoGroup) {
  const Stub stub([](const Correspondences& m, Selection& result) {
    for (std::size_t i = 0; i < m.size(); ++i) {
      result.mask[i] = 1;
      result.group.push_back(static_cast<std::int32_t>(m.left_x[i]));
    }
  });
  Correspondences m = matches(4);
  EXPECT_EQ(stub.select(m).group, (std::vector<std::int32_t>{0, 1, 2, 3}));
  m.left_y[1] = kNaN;
  EXPECT_EQ(stub.select(m).group, (std::vector<std::int32_t>{0, -1, 2, 3}));
}

TEST(Selector, AddsWhatTheAlgorithmIgnores) {
  const Stub stub([](const Correspondences&, Selection& result) { result.n_ignored = 2; });
  Correspondences m = matches(4);
  EXPECT_EQ(stub.select(m).n_ignored, 2u);
  m.left_x[1] = kNaN;
  EXPECT_EQ(stub.select(m).n_ignored, 3u);
  const Stub wrong([](const Correspondences&, Selection& result) { result.n_ignored = 80; });
  EXPECT_EQ(wrong.select(m).status, Status::kFailed);
  EXPECT_EQ(wrong.select(m).n_ignored, 1u);
}

TEST(Selector, CountsByItself) {
  const Stub stub([](const Correspondences&, Selection& result) {
    result.mask[0] = 1;
    result.n_input = 70;
    result.n_selected = 90;
    result.seconds = 1000;
  });
  Correspondences with_bad_row = matches(3);
  with_bad_row.left_x[1] = kNaN;
  for (const Correspondences& m : {matches(3), with_bad_row}) {
    const Selection s = stub.select(m);
    EXPECT_EQ(s.n_input, 3u);
    EXPECT_EQ(s.n_ignored, m.left_x[1] == 1 ? 0u : 1u);
    EXPECT_EQ(s.n_selected, 1u);
    EXPECT_LT(s.seconds, 1);
  }
}

struct OptionsOfConfident : ConfidenceOptions {
  void visit(OptionVisitor& visitor) const override { visitConfidence(visitor); }
};

/// Selects the first match and returns the status and the confidence that the test gives.
class Confident : public SelectorWithOptions<OptionsOfConfident> {
 public:
  std::string name() const override { return "confident"; }
  Status status = Status::kOk;
  std::string message;
  double confidence = 9.25;

 protected:
  void run(const Correspondences&, Workspace&, Selection& result) const override {
    result.mask[0] = 1;
    result.score = {1, 0, 0};
    result.model_kind = ModelKind::kHomography;
    result.model = cv::Matx33d::eye();
    result.status = status;
    result.message = message;
    result.confidence = confidence;
  }
};

TEST(Selector, IsUncertainBelowMinConfidenceAndKeepsTheAnswer) {
  Confident selector;
  EXPECT_EQ(selector.select(matches(3)).status, Status::kOk) << "the default is 0";
  selector.configure({{"min_confidence", "9.25"}});
  EXPECT_EQ(selector.select(matches(3)).status, Status::kOk);
  selector.configure({{"min_confidence", "9.3"}});
  Selection s = selector.select(matches(3));
  EXPECT_EQ(s.status, Status::kUncertain);
  EXPECT_EQ(s.message, "the confidence is 9.2, below min_confidence = 9.3");
  EXPECT_EQ(s.confidence, 9.25);
  EXPECT_EQ(s.mask, (Mask{1, 0, 0}));
  EXPECT_EQ(s.score, (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(s.model_kind, ModelKind::kHomography);
  EXPECT_EQ(s.n_selected, 1u);

  selector.message = "uniform samples";
  selector.confidence = 0;
  s = selector.select(matches(3));
  EXPECT_EQ(s.message, "the confidence is 0, below min_confidence = 9.3; uniform samples");

  for (const Status other : {Status::kTooFew, Status::kNoModel, Status::kTimeLimit}) {
    selector.status = other;
    s = selector.select(matches(3));
    EXPECT_EQ(s.status, other);
    EXPECT_EQ(s.message, "uniform samples");
  }
}

TEST(Selector, ComputesTheConfidenceOnlyWhereItDecides) {
  const Scene scene = homographyScene({200, 0.5, 0.5, 1});
  Correspondences m = scene.matches;
  Confident selector;
  selector.confidence = kNaN;
  EXPECT_TRUE(std::isnan(selector.select(matches(3)).confidence));
  selector.configure({{"min_confidence", "1"}});
  EXPECT_EQ(selector.select(matches(3)).confidence, 0) << "chance explains one selected match";

  const auto run = [&scene](const Correspondences& kept, Selection& result) {
    for (std::size_t i = 0; i < kept.size(); ++i) result.mask[i] = scene.inlier[i];
    result.model_kind = ModelKind::kHomography;
    result.model = scene.model;
    result.iterations = 100000;
  };
  Selection s = Stub(run).select(m);
  EXPECT_TRUE(std::isnan(s.confidence));
  addConfidence(m, s);
  EXPECT_EQ(s.confidence, confidenceOf(m, s, 100000, Workspace::ofThread()));
  EXPECT_GT(s.confidence, 100);
  const double confidence = s.confidence;

  // Rows that the selector never sees do not count.
  m.add({kNaN, 1}, {2, 3});
  m.distance.clear();
  m.second_distance.clear();
  s = Stub(run).select(m);
  addConfidence(m, s);
  EXPECT_EQ(s.confidence, confidence);

  for (const double set : {7.0, 0.0}) {
    s.confidence = set;
    addConfidence(m, s);
    EXPECT_EQ(s.confidence, set) << "what a selector has set is kept";
  }
  s.confidence = kNaN;
  for (const Status failed : {Status::kFailed, Status::kUnsupportedInput}) {
    s.status = failed;
    addConfidence(m, s);
    EXPECT_TRUE(std::isnan(s.confidence)) << toString(failed);
  }
  s.status = Status::kOk;
  s.mask.pop_back();
  addConfidence(m, s);
  EXPECT_TRUE(std::isnan(s.confidence)) << "another number of matches";
}

TEST(Selector, ComputesProbabilitiesOnDemand) {
  const Scene scene = homographyScene({400, 0.5, 0.5, 1});
  Correspondences m = scene.matches;
  const auto run = [&scene](const Correspondences& kept, Selection& result) {
    for (std::size_t i = 0; i < kept.size(); ++i) result.mask[i] = scene.inlier[i];
    result.model_kind = ModelKind::kHomography;
    result.model = scene.model;
  };
  Selection s = Stub(run).select(m);
  EXPECT_TRUE(s.probability.empty());
  EXPECT_TRUE(std::isnan(s.sigma));
  addProbability(m, s);
  ASSERT_EQ(s.probability.size(), m.size());
  EXPECT_GT(s.confidence, 100) << "it is computed, too";
  EXPECT_NEAR(s.sigma, 0.5, 0.1);
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (scene.inlier[i] != 0)
      EXPECT_GT(s.probability[i], 0.9) << i;
    else
      EXPECT_LT(s.probability[i], 0.1) << i;
  }
  const Selection first = s;

  m.add({kNaN, 1}, {2, 3});
  m.distance.push_back(1);
  m.second_distance.push_back(2);
  s = Stub(run).select(m);
  addProbability(m, s);
  EXPECT_EQ(s.probability.back(), 0) << "rows that are not usable";
  s.probability.pop_back();
  EXPECT_EQ(s.probability, first.probability);
  EXPECT_EQ(s.sigma, first.sigma);

  s.probability.assign(m.size(), 0.25F);
  addProbability(m, s);
  EXPECT_EQ(s.probability, std::vector<float>(m.size(), 0.25F)) << "what is there is kept";
  for (const Status failed : {Status::kFailed, Status::kUnsupportedInput}) {
    s.probability.clear();
    s.status = failed;
    addProbability(m, s);
    EXPECT_TRUE(s.probability.empty()) << toString(failed);
  }
  s.status = Status::kOk;
  s.mask.pop_back();
  addProbability(m, s);
  EXPECT_TRUE(s.probability.empty()) << "another number of matches";
}

TEST(Selector, TakesNoOptionsUnlessItSaysSo) {
  Stub stub(selectEven);
  stub.configure({});
  EXPECT_EQ(testing::errorOf<std::invalid_argument>([&stub] {
              stub.configure({{"alpha", "3"}});
            }),
            "takes no options, but was given alpha; a selector with options overrides configure()");
}

}  // namespace
}  // namespace corrsel::core
