#include <gtest/gtest.h>

#include <set>

#include "corrsel/selectors/ransac.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

RansacOptions fundamental(double threshold) {
  RansacOptions options;
  options.model = ModelKind::kFundamental;
  options.threshold = threshold;
  return options;
}

/// Squared error of match i as the models are defined: forward transfer error or Sampson distance.
double squaredError(const Selection& s, const Correspondences& m, std::size_t i) {
  const cv::Vec3d left(m.left_x[i], m.left_y[i], 1), right(m.right_x[i], m.right_y[i], 1);
  const cv::Vec3d to = s.model * left, from = s.model.t() * right;
  if (s.model_kind == ModelKind::kHomography) {
    const double dx = to[0] / to[2] - right[0], dy = to[1] / to[2] - right[1];
    return to[2] > 0 ? dx * dx + dy * dy : INFINITY;
  }
  const double residual = right.dot(to);
  return residual * residual / (to[0] * to[0] + to[1] * to[1] + from[0] * from[0] + from[1] * from[1]);
}

void expectMaskOfModel(const Selection& s, const Correspondences& m, double threshold) {
  ASSERT_EQ(s.score.size(), m.size());
  const double t2 = threshold * threshold;
  for (std::size_t i = 0; i < m.size(); ++i) {
    const double error = squaredError(s, m, i);
    if (std::abs(error - t2) > 1e-9 * t2) {
      EXPECT_EQ(s.mask[i], error <= t2 ? 1 : 0) << "match " << i << ", squared error " << error;
    }
    if (std::isfinite(error)) {
      EXPECT_NEAR(s.score[i], -error, 1e-4 * (1 + error));
    }
  }
}

TEST(Ransac, MaskBelongsToTheReturnedModel) {
  for (const bool refine : {true, false}) {
    for (const auto score : {RansacOptions::Score::kMsac, RansacOptions::Score::kInlierCount}) {
      for (const double threshold : {1.0, 3.0, 10.0}) {
        for (const ModelKind model : {ModelKind::kHomography, ModelKind::kFundamental}) {
          RansacOptions options;
          options.model = model;
          options.threshold = threshold;
          options.refine = refine;
          options.score = score;
          const Scene scene = model == ModelKind::kHomography ? homographyScene() : stereoScene();
          const Selection s = RansacSelector(options).select(scene.matches);
          SCOPED_TRACE(toString(model) + ", score " + std::to_string(int(score)) + ", " +
                       std::to_string(threshold));
          EXPECT_EQ(s.status, Status::kOk);
          EXPECT_EQ(s.model_kind, model);
          EXPECT_GT(s.n_selected, 100u);
          EXPECT_LT(s.n_selected, 400u);
          expectMaskOfModel(s, scene.matches, threshold);
        }
      }
    }
  }
}

TEST(Ransac, FindsTheRightMatches) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene plane = homographyScene({400, 0.4, 0.5, seed});
    const Selection h = RansacSelector().select(plane.matches);
    const Quality hq = quality(h.mask, plane.inlier);
    EXPECT_EQ(hq.recall, 100);
    EXPECT_EQ(hq.precision, 100);
    // Refined on all inliers, the model is much nearer to the truth than their noise.
    for (const cv::Point2d p : {cv::Point2d(0, 0), {700, 100}, {300, 500}}) {
      EXPECT_LT(cv::norm(projected(h.model, p.x, p.y) - projected(plane.model, p.x, p.y)), 1.0);
    }
    const Scene space = stereoScene({400, 0.6, 0.5, seed});
    const Quality fq = quality(RansacSelector(fundamental(2)).select(space.matches).mask, space.inlier);
    EXPECT_GT(fq.recall, 98);
    EXPECT_GT(fq.precision, 98);
  }
}

TEST(Ransac, RefinementLowersTheErrors) {
  double refined = 0, minimal = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = homographyScene({300, 0.5, 1.0, seed});
    RansacOptions options;
    const Selection with = RansacSelector(options).select(scene.matches);
    options.refine = false;
    const Selection without = RansacSelector(options).select(scene.matches);
    for (const double x : {50.0, 400.0, 750.0}) {
      const cv::Point2d truth = projected(scene.model, x, 300);
      refined += cv::norm(projected(with.model, x, 300) - truth);
      minimal += cv::norm(projected(without.model, x, 300) - truth);
    }
  }
  EXPECT_LT(refined, 0.5 * minimal);
}

/// Hypotheses that must be tried when `inliers` of n agree: ln(1-p) / ln(1-P), P by counting samples.
int hypotheses(double inliers, double n, int sample, double confidence) {
  double p = 1;
  for (int k = 0; k < sample; ++k) p *= (inliers - k) / (n - k);
  return int(std::ceil(std::log(1 - confidence) / std::log(1 - p)));
}

TEST(Ransac, StopsAfterTheSamplesThatTheInliersAskFor) {
  for (const auto score : {RansacOptions::Score::kMsac, RansacOptions::Score::kInlierCount}) {
    for (const double confidence : {0.99, 0.995, 0.9999}) {
      for (const int seed : {0, 1, 2}) {
        RansacOptions options;
        options.score = score;
        options.confidence = confidence;
        options.seed = seed;
        options.threshold = 1;
        // Samples that the check refuses count as drawn, not as hypotheses.
        const Scene plane = homographyScene({100, 0.5, 0.0, 20});
        const int samples = hypotheses(50, 100, 4, confidence);
        const int tried = RansacSelector(options).select(plane.matches).iterations;
        EXPECT_LT(tried, samples);
        EXPECT_GT(tried, samples / 20);
        // Nearly every sample of seven passes.
        options.model = ModelKind::kFundamental;
        options.threshold = 0.05;
        const Scene space = stereoScene({60, 0.7, 0.0, 21});
        const Selection s = RansacSelector(options).select(space.matches);
        EXPECT_EQ(s.iterations, hypotheses(double(s.n_selected), 60, 7, confidence));
        EXPECT_GE(s.n_selected, 42u);
      }
    }
  }
}

TEST(Ransac, StopsAtOnceWhereAllAgree) {
  EXPECT_EQ(RansacSelector().select(homographyScene({50, 1.0, 0.0, 1}).matches).iterations, 1);
}

TEST(Ransac, NeverTriesMoreThanAllowed) {
  RansacOptions options;
  options.max_iterations = 37;
  const Scene wrong = homographyScene({200, 0.05, 0.5, 2});
  EXPECT_EQ(RansacSelector(options).select(wrong.matches).iterations, 37);
  // Confidence 1 never stops early.
  options.confidence = 1;
  EXPECT_EQ(RansacSelector(options).select(homographyScene({200, 0.9, 0.5, 2}).matches).iterations, 37);
}

/// A search that does not end by itself.
OptionMap endless(const OptionMap& more) {
  OptionMap options = {{"max_iterations", "10000000"}, {"confidence", "1"}};
  options.insert(more.begin(), more.end());
  return options;
}

/// 5000 matches of which next to none is right, until the clock has been read twenty times.
TEST(Ransac, StopsAtTheTimeLimit) {
  const Scene plane = homographyScene({5000, 0.004, 0.5, 2}), space = stereoScene({5000, 0.004, 0.5, 2});
  for (const std::string spec :
       {"ransac:h", "ransac:f", "ransac:count", "ransac:lo", "ransac:prosac", "usac:h", "usac:f"}) {
    SCOPED_TRACE(spec);
    const Correspondences& m = spec.back() == 'f' ? space.matches : plane.matches;
    // An error one way only, which expectMaskOfModel() knows.
    OptionMap options = endless({{"error", "transfer"}, {"threshold", "10"}, {"sprt", "false"}});
    options["max_seconds"] = "19.5";
    const TickingClock clock(1);
    const Selection s = createSelector(spec, options)->select(m);
    EXPECT_EQ(clock.looks(), 21);
    EXPECT_EQ(s.status, Status::kTimeLimit);
    EXPECT_EQ(s.message, "stopped after " + std::to_string(s.iterations) + " hypotheses, max_seconds = 19.5");
    EXPECT_GT(s.iterations, 0);
    EXPECT_GT(s.n_selected, 4u);
    expectMaskOfModel(s, m, 10);
    // The limit decides how many hypotheses are tried, and nothing else.
    options["max_seconds"] = "0";
    options["max_iterations"] = std::to_string(s.iterations);
    const Selection counted = createSelector(spec, options)->select(m);
    EXPECT_EQ(counted.status, Status::kOk);
    EXPECT_EQ(counted.mask, s.mask);
    EXPECT_EQ(counted.score, s.score);
    EXPECT_EQ(counted.model, s.model);
  }
}

TEST(Ransac, SaysAtTheTimeLimitThatThereIsNoModel) {
  const Scene scene = homographyScene({5000, 0.0, 0.5, 2});
  for (const char* spec : {"ransac:h", "ransac:f", "usac:h", "usac:f"}) {
    SCOPED_TRACE(spec);
    const TickingClock clock(1);
    const Selection none = createSelector(spec, {{"max_seconds", "0.5"}})->select(scene.matches);
    EXPECT_EQ(none.status, Status::kTooLarge);
    EXPECT_EQ(none.message, "stopped after 0 hypotheses, none of them good enough, max_seconds = 0.5");
    EXPECT_EQ(none.iterations, 0);
    EXPECT_EQ(none.mask, Mask(5000, 0));
    EXPECT_EQ(none.model_kind, ModelKind::kNone);
    EXPECT_TRUE(none.score.empty());
  }
  // No bad model passes this test.
  const TickingClock clock(1);
  const Selection s =
      createSelector("usac:h",
                     endless({{"max_seconds", "19.5"}, {"threshold", "0.01"}, {"sprt_inlier_ratio", "0.9"}}))
          ->select(scene.matches);
  EXPECT_EQ(s.status, Status::kTimeLimit);
  EXPECT_EQ(s.message, "stopped after " + std::to_string(s.iterations) +
                           " hypotheses, none of them good enough, max_seconds = 19.5");
  EXPECT_GT(s.iterations, 0);
  EXPECT_EQ(s.mask, Mask(5000, 0));
  EXPECT_EQ(s.model_kind, ModelKind::kNone);
}

TEST(Ransac, UnverifiedModelsStaySoAtTheTimeLimit) {
  Correspondences m = homographyScene({40, 0.0, 0.5, 2}).matches;
  m.distance.clear();
  m.second_distance.clear();
  const TickingClock clock(1);
  const Selection s =
      createSelector("ransac:prosac", endless({{"max_seconds", "19.5"}, {"threshold", "0.01"}}))->select(m);
  EXPECT_EQ(s.status, Status::kTimeLimit);
  EXPECT_EQ(s.model_kind, ModelKind::kHomography);
  EXPECT_EQ(s.mask, Mask(40, 0));
  EXPECT_EQ(s.message,
            "the matches have neither descriptor distances nor probabilities, so samples are drawn uniformly "
            "instead of by "
            "PROSAC; "
            "stopped after " +
                std::to_string(s.iterations) +
                " hypotheses, max_seconds = 19.5; only its own sample agrees with the best model, which is "
                "therefore unverified");
}

TEST(Ransac, LimitsThatAreNotReachedChangeNothing) {
  const Scene plane = homographyScene({1000, 0.2, 0.5, 3}), space = stereoScene({1000, 0.5, 0.5, 3});
  for (const std::string spec : {"ransac:h", "ransac:f", "usac:h", "usac:f"}) {
    SCOPED_TRACE(spec);
    const Correspondences& m = spec.back() == 'f' ? space.matches : plane.matches;
    const Selection without = createSelector(spec)->select(m);
    EXPECT_EQ(without.status, Status::kOk);
    for (const char* seconds : {"0", "1000"}) {
      const Selection with = createSelector(spec, {{"max_seconds", seconds}})->select(m);
      EXPECT_EQ(with.status, Status::kOk);
      EXPECT_EQ(with.message, without.message);
      EXPECT_EQ(with.mask, without.mask);
      EXPECT_EQ(with.score, without.score);
      EXPECT_EQ(with.model, without.model);
      EXPECT_EQ(with.iterations, without.iterations);
    }
  }
}

TEST(Ransac, SeedDecidesTheSamplesAndIsListed) {
  const Scene scene = homographyScene({200, 0.5, 1.0, 3});
  std::set<float> answers;
  for (int seed = 0; seed < 6; ++seed) {
    const auto first = createSelector("ransac:h", {{"seed", std::to_string(seed)}, {"refine", "false"}});
    const auto second = createSelector("ransac:h", {{"seed", std::to_string(seed)}, {"refine", "false"}});
    const Selection a = first->select(scene.matches), b = second->select(scene.matches);
    EXPECT_EQ(a.mask, b.mask);
    EXPECT_EQ(a.score, b.score);
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.iterations, b.iterations);
    answers.insert(a.score[0]);
    bool listed = false;
    for (const OptionText& option : listOptions(first->options())) {
      listed = listed || (option.name == "seed" && option.value == std::to_string(seed));
    }
    EXPECT_TRUE(listed);
  }
  EXPECT_GT(answers.size(), 3u);
}

TEST(Ransac, NeedsASample) {
  for (const auto& [spec, sample] : {std::pair<const char*, std::size_t>{"ransac:h", 4}, {"ransac:f", 7}}) {
    const Correspondences all = stereoScene({20, 1.0, 0.0, 4}).matches;
    for (std::size_t n = 0; n < sample; ++n) {
      std::vector<std::uint32_t> rows(n);
      std::iota(rows.begin(), rows.end(), 0U);
      const Selection s = createSelector(spec)->select(all.subset(rows));
      EXPECT_EQ(s.status, Status::kTooFew);
      EXPECT_EQ(s.model_kind, ModelKind::kNone);
      EXPECT_EQ(s.n_selected, 0u);
      EXPECT_TRUE(contains(s.message, std::to_string(n) + " matches, a ")) << s.message;
      EXPECT_TRUE(contains(s.message, "needs " + std::to_string(sample))) << s.message;
    }
  }
}

TEST(Ransac, ExactlyASampleIsUnverified) {
  std::vector<std::uint32_t> rows = {0, 1, 2, 3};
  const Scene plane = homographyScene({20, 1.0, 0.0, 5});
  const Selection h = createSelector("ransac:h")->select(plane.matches.subset(rows));
  EXPECT_EQ(h.status, Status::kDegenerate);
  EXPECT_EQ(h.model_kind, ModelKind::kHomography);
  EXPECT_EQ(h.mask, Mask(4, 0));
  EXPECT_LT(cv::norm(projected(h.model, 100, 100) - projected(plane.model, 100, 100)), 0.01);
  EXPECT_TRUE(contains(h.message, "unverified"));
  rows = {0, 1, 2, 3, 4};
  EXPECT_EQ(createSelector("ransac:h")->select(plane.matches.subset(rows)).mask, Mask(5, 1));

  const Scene space = stereoScene({20, 1.0, 0.0, 6});
  rows = {0, 1, 2, 3, 4, 5, 6};
  const Selection f = createSelector("ransac:f")->select(space.matches.subset(rows));
  EXPECT_EQ(f.status, Status::kDegenerate);
  EXPECT_EQ(f.model_kind, ModelKind::kFundamental);
  EXPECT_EQ(f.mask, Mask(7, 0));
  rows.push_back(7);
  EXPECT_EQ(createSelector("ransac:f")->select(space.matches.subset(rows)).mask, Mask(8, 1));
}

TEST(Ransac, FlagsPointsWithoutAValidSample) {
  for (const char* spec : {"ransac:h", "ransac:f"}) {
    Random random(8);
    // All equal; on one line in both images, at exact and at rounded places; in one image only.
    Correspondences equal, line, slanted, left_line, right_line;
    for (int i = 0; i < 30; ++i) {
      const float t = float(random.uniform(0, 500));
      equal.add({10, 20}, {30, 40});
      line.add({float(i), float(2 * i)}, {float(3 * i + 1), 7});
      slanted.add({t, 0.3f * t + 11}, {0.7f * t + 3, 200 - 0.9f * t});
      const cv::Point2f free = uniformPoint(random, 500, 500);
      left_line.add({t, 0.3f * t + 11}, free);
      right_line.add(free, {2900 + 0.1f * t, 3100 - 0.17f * t});
    }
    for (const Correspondences& m : {equal, line, slanted, left_line, right_line}) {
      const Selection s = createSelector(spec)->select(m);
      EXPECT_EQ(s.status, Status::kDegenerate) << spec << ": " << s.message;
      EXPECT_EQ(s.n_selected, 0u) << spec;
      EXPECT_EQ(s.model_kind, ModelKind::kNone) << spec;
    }
  }
}

TEST(Ransac, IdenticalImagesGiveTheIdentity) {
  Correspondences m = homographyScene({100, 1.0, 0.0, 9}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  const Selection s = RansacSelector().select(m);
  EXPECT_EQ(s.n_selected, 100u);
  EXPECT_LT(cv::norm(s.model - cv::Matx33d::eye()), 1e-6);
}

TEST(Ransac, ReachesItsMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  EXPECT_GE(adelaideMeans("ransac:f", {{"threshold", "1.5"}}).f, 76);
  EXPECT_GE(adelaideMeans("ransac:f", {{"threshold", "10"}}).f, 90);
}

}  // namespace
}  // namespace corrsel::core
