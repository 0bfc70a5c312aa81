#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "corrsel/selectors/gtm.h"
#include "kernels/kernels.h"
#include "selectors/parts/otsu.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

cv::Matx22d linear(const AffineFrame& f) { return {f[0], f[1], f[3], f[4]}; }

/// Payoffs by definition.
Eigen::MatrixXd payoffs(const Correspondences& m, double lambda, bool one_to_one) {
  const auto n = static_cast<Eigen::Index>(m.size());
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(n, n);
  const auto left = [&m](std::size_t i) { return cv::Vec2d(m.left_x[i], m.left_y[i]); };
  const auto right = [&m](std::size_t i) { return cv::Vec2d(m.right_x[i], m.right_y[i]); };
  const auto transfer = [&](std::size_t i, const cv::Vec2d& x) {
    return right(i) + linear(m.right_frame[i]) * linear(m.left_frame[i]).inv() * (x - left(i));
  };
  for (std::size_t i = 0; i < m.size(); ++i) {
    for (std::size_t j = 0; j < m.size(); ++j) {
      if (i == j || (one_to_one && (left(i) == left(j) || right(i) == right(j)))) continue;
      const double error = std::max(cv::norm(transfer(i, left(i)) - transfer(j, left(i)), cv::NORM_L1),
                                    cv::norm(transfer(i, left(j)) - transfer(j, left(j)), cv::NORM_L1));
      p(Eigen::Index(i), Eigen::Index(j)) = std::exp(-lambda * error);
    }
  }
  return p;
}

Eigen::VectorXd replicator(const Eigen::MatrixXd& p, int steps) {
  Eigen::VectorXd q = Eigen::VectorXd::Constant(p.rows(), 1.0 / double(p.rows()));
  for (int k = 0; k < steps; ++k) {
    const Eigen::VectorXd payoff = p * q;
    q = q.cwiseProduct(payoff) / q.dot(payoff);
  }
  return q / q.maxCoeff();
}

Mask aboveOtsu(const Eigen::VectorXd& q) {
  const std::vector<double> values(q.data(), q.data() + q.size());
  const double t = otsuThreshold(values, q.minCoeff(), q.maxCoeff(), 256).value();
  Mask mask;
  for (const double value : values) mask.push_back(value > t ? 1 : 0);
  return mask;
}

Scene framedScene(std::size_t n, double inlier_ratio, std::uint64_t seed, double frame_noise = 0.05) {
  Scene scene = homographyScene({n, inlier_ratio, 1.0, seed});
  addFrames(scene, frame_noise, seed);
  return scene;
}

/// Inliers and outliers, some of which share a point.
Correspondences manyToOne(std::size_t n, std::uint64_t seed) {
  Correspondences m = framedScene(n, 0.5, seed).matches;
  for (std::size_t i = 0; i + 10 < n; i += 10) {
    m.left_x[i] = m.left_x[i + 1];
    m.left_y[i] = m.left_y[i + 1];
    m.right_x[i + 2] = m.right_x[i + 3];
    m.right_y[i + 2] = m.right_y[i + 3];
  }
  return m.subset(permutation(n, seed));
}

TEST(Gtm, FollowsTheDefinition) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const std::size_t n : {37, 301}) {
      const Correspondences m = manyToOne(n, seed);
      for (const double lambda : {1e-4, 1e-3}) {
        for (const bool one_to_one : {true, false}) {
          SCOPED_TRACE(std::to_string(n) + " matches, lambda " + std::to_string(lambda));
          GtmOptions options;
          options.lambda = lambda;
          options.one_to_one = one_to_one;
          const Eigen::VectorXd q = replicator(payoffs(m, lambda, one_to_one), 100);
          const Selection s = GtmSelector(options).select(m);
          EXPECT_EQ(s.mask, aboveOtsu(q));
          EXPECT_EQ(s.status, Status::kOk);
          EXPECT_EQ(s.iterations, 100);
          for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(s.score[i], q(Eigen::Index(i)), 1e-4);
        }
      }
    }
  }
}

TEST(Gtm, EqualMatchesPlayEachOtherUnlessOneToOne) {
  Correspondences m = manyToOne(80, 4);
  std::vector<std::uint32_t> rows(80);
  std::iota(rows.begin(), rows.end(), 0U);
  for (std::uint32_t i = 0; i < 40; ++i) rows.insert(rows.end(), i % 4, i);
  m = m.subset(rows);
  for (const bool one_to_one : {true, false}) {
    GtmOptions options;
    options.one_to_one = one_to_one;
    options.steps = 30;
    const Eigen::VectorXd q = replicator(payoffs(m, options.lambda, one_to_one), 30);
    const Selection s = GtmSelector(options).select(m);
    EXPECT_EQ(s.mask, aboveOtsu(q));
    EXPECT_EQ(s.iterations, 30);
    for (std::size_t i = 0; i < m.size(); ++i) ASSERT_NEAR(s.score[i], q(Eigen::Index(i)), 1e-4);
  }
}

TEST(Gtm, EquilibriumIsOne) {
  for (const std::size_t n : {60, 500}) {
    const Correspondences m = manyToOne(n, 5);
    const Eigen::MatrixXd p = payoffs(m, 2e-5 * 1000 / double(n), true);
    const Selection s = createSelector("gtm:equilibrium", {{"min_share", "0.3"}})->select(m);
    Eigen::VectorXd q(p.rows());
    for (std::size_t i = 0; i < n; ++i) q(Eigen::Index(i)) = double(s.score[i]);
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(s.mask[i], s.score[i] > 0.3f);
    EXPECT_EQ(q.maxCoeff(), 1);
    q /= q.sum();
    const Eigen::VectorXd payoff = p * q;
    const double mean = q.dot(payoff), tolerance = 2e-3 * (1 - mean);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      EXPECT_LE(payoff(i), mean + tolerance);
      if (q(i) > 0) {
        EXPECT_GE(payoff(i), mean - tolerance);
      }
    }
    EXPECT_TRUE(s.n_selected > 10 && s.n_selected < n);
  }
}

TEST(Gtm, AnswersAlikeAtEveryKernelLevelAndWithoutMemory) {
  const LevelGuard guard;
  const Correspondences m = manyToOne(1003, 7);
  for (const char* spec : {"gtm", "gtm:equilibrium"}) {
    const Selection expected = createSelector(spec)->select(m);
    EXPECT_EQ(expected.status, Status::kOk);
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      for (const char* limit : {"0", "1", "2048"}) {
        const Selection s = createSelector(spec, {{"memory_limit", limit}})->select(m);
        EXPECT_EQ(s.mask, expected.mask) << spec << " " << toString(level) << " " << limit;
        EXPECT_EQ(s.score, expected.score) << spec << " " << toString(level) << " " << limit;
        EXPECT_EQ(s.iterations, expected.iterations);
      }
    }
  }
}

TEST(Gtm, AnswersAlikeOnAnyNumberOfThreads) {
  const Correspondences m = manyToOne(2300, 11);
  for (const char* spec : {"gtm", "gtm:equilibrium"}) {
    const Selection expected = createSelector(spec)->select(m);
    EXPECT_GT(expected.n_selected, 0u);
    for (const char* threads : {"2", "3"}) {
      const Selection s = createSelector(spec, {{"threads", threads}})->select(m);
      EXPECT_EQ(s.mask, expected.mask) << spec << " " << threads;
      EXPECT_EQ(s.score, expected.score) << spec << " " << threads;
      EXPECT_EQ(s.iterations, expected.iterations);
    }
  }
}

TEST(Gtm, FollowsTheDefinitionForManySteps) {
  // Products are mostly combinations of earlier ones: their errors must not add up.
  const Correspondences m = manyToOne(300, 8);
  for (const int steps : {1, 2, 1000}) {
    GtmOptions options;
    options.lambda = 1e-3;
    options.steps = steps;
    const Eigen::VectorXd q = replicator(payoffs(m, options.lambda, true), steps);
    const Selection s = GtmSelector(options).select(m);
    EXPECT_EQ(s.iterations, steps);
    for (std::size_t i = 0; i < m.size(); ++i) ASSERT_NEAR(s.score[i], q(Eigen::Index(i)), 5e-4) << steps;
  }
}

TEST(Gtm, StopsAtTheTimeLimit) {
  const Correspondences m = manyToOne(1500, 9);
  for (const char* spec : {"gtm", "gtm:equilibrium"}) {
    SCOPED_TRACE(spec);
    const TickingClock clock(1);
    const Selection none = createSelector(spec, {{"max_seconds", "0.5"}})->select(m);
    EXPECT_EQ(none.status, Status::kTooLarge);
    EXPECT_EQ(none.message, "stopped after 0 steps, max_seconds = 0.5");
    EXPECT_EQ(none.mask, Mask(1500, 0));
    EXPECT_EQ(clock.looks(), 2);
  }
  // Stops at the limit, and selects the same as with that number of steps.
  const TickingClock clock(1);
  const OptionMap limited = {{"steps", "100000"}, {"max_seconds", "100.5"}};
  const Selection stopped = createSelector("gtm", limited)->select(m);
  EXPECT_EQ(stopped.status, Status::kTimeLimit);
  EXPECT_EQ(clock.looks(), 102);
  EXPECT_TRUE(stopped.iterations > 1 && stopped.iterations < 100) << stopped.iterations;
  EXPECT_GT(stopped.n_selected, 0u);
  const OptionMap counted = {{"steps", std::to_string(stopped.iterations)}, {"max_seconds", "0"}};
  const Selection same = createSelector("gtm", counted)->select(m);
  EXPECT_EQ(same.status, Status::kOk);
  EXPECT_EQ(same.mask, stopped.mask);
  EXPECT_EQ(same.score, stopped.score);
  EXPECT_EQ(clock.looks(), 103) << "without a limit the clock is read at the beginning only";
}

TEST(Gtm, NamesTheMissingInput) {
  Correspondences m = framedScene(30, 0.5, 10).matches;
  const Correspondences complete = m;
  m.right_frame.clear();
  EXPECT_EQ(GtmSelector().select(m).status, Status::kUnsupportedInput);
  EXPECT_EQ(GtmSelector().select(m).message, "gtm needs the local affine frames of the right features");
  m.left_frame.clear();
  EXPECT_EQ(GtmSelector().select(m).message, "gtm needs the local affine frames of the left features");
  EXPECT_EQ(GtmSelector().select({}).status, Status::kOk);
  m = complete;
  m.right_size = {};
  EXPECT_EQ(GtmSelector().select(m).status, Status::kOk);
  EXPECT_EQ(createSelector("gtm", {{"normalize_lambda", "true"}})->select(m).message,
            "gtm needs the size of the right image");
}

TEST(Gtm, NormalizesLambdaByTheDiagonal) {
  const Correspondences m = framedScene(200, 0.5, 11).matches;  // 800 x 600: a diagonal of 1000
  Correspondences large = m;
  for (auto* column : {&large.left_x, &large.left_y, &large.right_x, &large.right_y}) {
    for (float& value : *column) value *= 2;
  }
  large.right_size = {1600, 1200};
  const Selection plain = createSelector("gtm")->select(m);
  EXPECT_EQ(createSelector("gtm", {{"normalize_lambda", "true"}})->select(m).score, plain.score);
  EXPECT_EQ(createSelector("gtm", {{"normalize_lambda", "true"}})->select(large).score, plain.score);
  EXPECT_NE(createSelector("gtm")->select(large).score, plain.score);
}

TEST(Gtm, SetsUnusableFramesAside) {
  const Scene scene = framedScene(60, 0.7, 12);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const AffineFrame bad[] = {{nan, 0, 0, 0, 1, 0}, {1, 0, 0, inf, 1, 0},        {0, 0, 0, 0, 0, 0},
                             {2, 4, 0, 1, 2, 0},   {10.1f, 0, 0, 0, 1, 0},      {3e38f, 0, 0, 0, 3e38f, 0},
                             {1, 2, 0, 3, nan, 0}, {1e-30f, 0, 0, 0, 1e-30f, 0}};
  Correspondences m = scene.matches;
  std::vector<std::uint32_t> good;
  for (std::uint32_t i = 0; i < m.size(); ++i) {
    if (i % 3 != 0) {
      good.push_back(i);
      continue;
    }
    (i % 2 == 0 ? m.left_frame : m.right_frame)[i] = bad[i / 3 % 8];
  }
  for (const char* spec : {"gtm", "gtm:equilibrium"}) {
    const Selection expected = createSelector(spec)->select(m.subset(good));
    const Selection s = createSelector(spec)->select(m);
    EXPECT_EQ(s.status, Status::kOk);
    EXPECT_EQ(s.message, "20 matches have no usable frames");
    EXPECT_EQ(s.n_selected, expected.n_selected);
    for (std::size_t k = 0; k < good.size(); ++k) {
      EXPECT_EQ(s.mask[good[k]], expected.mask[k]);
      EXPECT_EQ(s.score[good[k]], expected.score[k]);
    }
    EXPECT_TRUE(std::isnan(s.score[0]));
  }
  // Ten times longer than wide is still fine.
  m = scene.matches;
  m.left_frame[1] = {10, 0, 0, 0, 1, 0};
  EXPECT_FALSE(std::isnan(GtmSelector().select(m).score[1]));
  m.left_frame.assign(m.size(), bad[2]);
  EXPECT_EQ(GtmSelector().select(m).status, Status::kDegenerate);
  EXPECT_EQ(GtmSelector().select(m).mask, Mask(60, 0));
}

TEST(Gtm, DecidesFewAndEqualMatchesByTheRule) {
  const AffineFrame unit = {1, 0, 0, 0, 1, 0};
  const auto withFrames = [&unit](Correspondences m) {
    m.left_frame.assign(m.size(), unit);
    m.right_frame = m.left_frame;
    return m;
  };
  Correspondences m;
  m.add({10, 20}, {30, 40});
  for (const char* spec : {"gtm", "gtm:equilibrium"}) {
    const Selection one = createSelector(spec)->select(withFrames(m));
    EXPECT_EQ(one.mask, Mask(1, 0)) << spec;
    EXPECT_EQ(one.status, Status::kOk);
    EXPECT_EQ(one.message, "no two matches agree");
  }
  // Two matches with an error of 100 px: payoff exp(-100 lambda) against 1/e.
  Correspondences two = m;
  two.add({110, 20}, {130, 140});
  EXPECT_EQ(createSelector("gtm", {{"lambda", "0.0099"}})->select(withFrames(two)).mask, Mask(2, 1));
  EXPECT_EQ(createSelector("gtm", {{"lambda", "0.0101"}})->select(withFrames(two)).mask, Mask(2, 0));
  // Many: what rounding makes of equal populations is no difference.
  Correspondences many = framedScene(1500, 1.0, 13).matches;
  many.right_x = many.left_x;
  many.right_y = many.left_y;
  const Selection equal = GtmSelector().select(withFrames(many));
  EXPECT_EQ(equal.mask, Mask(1500, 1));
  EXPECT_EQ(equal.status, Status::kOk);
  EXPECT_EQ(equal.message, "no match stands out");
  // So far apart that no payoff is left.
  EXPECT_EQ(createSelector("gtm", {{"lambda", "1"}})->select(withFrames(two)).message,
            "no two matches agree");

  m = withFrames(m.subset(std::vector<std::uint32_t>(40, 0)));
  for (const char* spec : {"gtm", "gtm:equilibrium"}) {
    const Selection all = createSelector(spec, {{"one_to_one", "false"}})->select(m);
    EXPECT_EQ(all.mask, Mask(40, 1)) << spec;
    EXPECT_EQ(all.status, Status::kDegenerate);
    EXPECT_EQ(all.message, "all matches are equal");
    EXPECT_EQ(createSelector(spec)->select(m).mask, Mask(40, 0));
    EXPECT_EQ(createSelector(spec)->select(m).status, Status::kDegenerate);
  }
}

TEST(Gtm, EquilibriumOfTinyPayoffsIsASmallGroup) {
  const Scene scene = framedScene(1000, 0.5, 14);
  const Selection s = createSelector("gtm:equilibrium", {{"lambda", "0.1"}})->select(scene.matches);
  EXPECT_GT(s.iterations, 0);
  EXPECT_TRUE(s.n_selected >= 2 && s.n_selected < 100) << s.n_selected;
  EXPECT_GT(quality(s.mask, scene.inlier).precision, 90);
}

TEST(Gtm, FindsTheRightMatches) {
  for (const double inlier_ratio : {0.3, 0.5, 0.8}) {
    for (const std::size_t n : {200, 2000}) {
      const Scene scene = framedScene(n, inlier_ratio, 6, 0.1);
      for (const char* spec : {"gtm", "gtm:equilibrium"}) {
        const Quality q = quality(createSelector(spec)->select(scene.matches).mask, scene.inlier);
        EXPECT_GT(q.precision, 90) << spec << " " << n << " " << inlier_ratio;
        EXPECT_GT(q.recall, 90) << spec << " " << n << " " << inlier_ratio;
      }
    }
  }
}

}  // namespace
}  // namespace corrsel::core
