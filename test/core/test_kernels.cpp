#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "corrsel/random.h"
#include "geometry/fundamental.h"
#include "geometry/homography.h"
#include "geometry/residual.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Restores the level that was in use.
class Kernels : public ::testing::Test {
 protected:
  ~Kernels() override { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

// Those of points; test_essential_model has that of rays.
constexpr Residual kEveryResidual[] = {Residual::kTransfer, Residual::kSymmetricTransfer, Residual::kSampson,
                                       Residual::kSmallerTransfer};
static_assert(sizeof kEveryResidual / sizeof *kEveryResidual == kResiduals - 1);

ResidualModel modelOf(Residual residual, const Scene& plane, const Scene& space) {
  ResidualModel model{};
  const cv::Matx33d forward = residual == Residual::kSampson ? space.model : plane.model;
  const cv::Matx33d backward = plane.model.inv();
  for (int i = 0; i < 9; ++i) {
    model.forward[i] = static_cast<float>(forward.val[i]);
    model.backward[i] = static_cast<float>(backward.val[i]);
  }
  return model;
}

MatchColumns columns(const Correspondences& m, std::size_t size) {
  return {m.left_x.data(), m.left_y.data(), m.right_x.data(), m.right_y.data(), size};
}

TEST_F(Kernels, LevelsAreNamedAndOrdered) {
  const std::vector<KernelLevel> levels = supportedKernelLevels();
  ASSERT_GE(levels.size(), 2u);
  EXPECT_EQ(toString(levels[0]), "plain");
  EXPECT_EQ(toString(levels[1]), "baseline");
  for (const KernelLevel level : levels) {
    setKernelLevel(level);
    EXPECT_EQ(kernelLevel(), level);
  }
  if (levels.back() != KernelLevel::kAvx512Vnni) {
    EXPECT_NE(errorOf<std::invalid_argument>([] { setKernelLevel(KernelLevel::kAvx512Vnni); }), "");
  }
}

TEST_F(Kernels, ErrorsAndScoresAreTheSameAtEveryLevel) {
  const Scene plane = homographyScene({1003, 0.5, 2.0, 5}), space = stereoScene({1003, 0.5, 2.0, 5});
  for (const Residual residual : kEveryResidual) {
    const auto number = static_cast<std::size_t>(residual);
    const Scene& scene = residual == Residual::kSampson ? space : plane;
    const ResidualModel model = modelOf(residual, plane, space);
    for (const std::size_t n : {1, 3, 4, 7, 8, 15, 16, 17, 31, 255, 256, 300, 1003}) {
      SCOPED_TRACE(std::to_string(number) + " " + std::to_string(n));
      const MatchColumns m = columns(scene.matches, n);
      setKernelLevel(KernelLevel::kPlain);
      std::vector<float> expected(n);
      kernels().residuals.errors[number](model, m, 0, n, expected.data());
      for (const bool msac : {true, false}) {
        for (const bool sprt : {true, false}) {
          for (const double share : {2.0, 0.6, 0.2}) {
            ScoreRule rule{9.0F, msac ? ScoreRule::kOutlierCost / 9.0F : 0.0F,
                           std::int64_t(share * double(n) * ScoreRule::kOutlierCost)};
            rule.start = n > 40 ? 32 : 0;
            if (sprt) {
              rule.log_consistent = std::log(0.05 / 0.5);
              rule.log_inconsistent = std::log(0.95 / 0.5);
              rule.log_decision = std::log(10.0);
            }
            setKernelLevel(KernelLevel::kPlain);
            const ModelScore wanted = kernels().residuals.score[number](model, m, rule);
            for (const KernelLevel level : supportedKernelLevels()) {
              setKernelLevel(level);
              std::vector<float> errors(n);
              kernels().residuals.errors[number](model, m, 0, n, errors.data());
              ASSERT_EQ(errors, expected) << toString(level);
              const ModelScore score = kernels().residuals.score[number](model, m, rule);
              ASSERT_EQ(score.cost, wanted.cost) << toString(level);
              ASSERT_EQ(score.inliers, wanted.inliers) << toString(level);
              ASSERT_EQ(score.seen, wanted.seen) << toString(level);
              ASSERT_EQ(score.rejected, wanted.rejected) << toString(level);
              ASSERT_EQ(score.rejected_by_sprt, wanted.rejected_by_sprt) << toString(level);
            }
          }
        }
      }
    }
  }
}

/// Compares an error in double precision at every level with that of single matches.
void expectPixelErrors(const Correspondences& m, const cv::Matx33d& model,
                       ResidualKernels::PixelErrors ResidualKernels::*kernel,
                       double (*error)(const cv::Matx33d&, double, double, double, double)) {
  for (const std::size_t begin : {0, 1, 100}) {
    std::vector<double> expected;
    for (std::size_t i = begin; i < m.size(); ++i)
      expected.push_back(error(model, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]));
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      std::vector<double> errors(expected.size());
      (kernels().residuals.*kernel)(model.val, columns(m, m.size()), begin, m.size(), errors.data());
      EXPECT_EQ(errors, expected) << toString(level);
    }
  }
}

TEST_F(Kernels, PixelErrorsAreThoseOfTheHomographyAtEveryLevel) {
  const Scene plane = homographyScene({103, 0.5, 2.0, 5});
  const cv::Matx33d in_front = plane.model, behind = plane.model * -1.0;
  for (const cv::Matx33d& model : {in_front, behind})
    expectPixelErrors(plane.matches, model, &ResidualKernels::pixel_transfer, homographyError);
}

TEST_F(Kernels, PixelErrorsAreThoseOfTheFundamentalMatrixAtEveryLevel) {
  Scene space = stereoScene({103, 0.5, 2.0, 5});
  expectPixelErrors(space.matches, space.model, &ResidualKernels::pixel_sampson, sampsonError);
  // Both epipoles are at (0, 0). A match there has an error of 0, or an infinite one with another matrix.
  for (std::vector<float>* const column :
       {&space.matches.left_x, &space.matches.left_y, &space.matches.right_x, &space.matches.right_y})
    (*column)[50] = 0;
  const cv::Matx33d at_epipoles(0, 1, 0, -1, 0, 0, 0, 0, 0), constant(0, 0, 0, 0, 0, 0, 0, 0, 1);
  for (const cv::Matx33d& model : {at_epipoles, constant})
    expectPixelErrors(space.matches, model, &ResidualKernels::pixel_sampson, sampsonError);
}

TEST_F(Kernels, ScoreAddsUpTheErrors) {
  const Scene plane = homographyScene({777, 0.5, 2.0, 6}), space = stereoScene({777, 0.5, 2.0, 6});
  for (const Residual residual : kEveryResidual) {
    const auto number = static_cast<std::size_t>(residual);
    const Scene& scene = residual == Residual::kSampson ? space : plane;
    const ResidualModel model = modelOf(residual, plane, space);
    const MatchColumns m = columns(scene.matches, 777);
    std::vector<float> errors(777);
    kernels().residuals.errors[number](model, m, 0, 777, errors.data());
    std::size_t inliers = 0;
    double cost = 0;
    for (const float error : errors) {
      inliers += error <= 4.0F ? 1 : 0;
      cost += error <= 4.0F ? error / 4.0 : 1.0;
    }
    ScoreRule rule{4.0F, ScoreRule::kOutlierCost / 4.0F, std::numeric_limits<std::int64_t>::max()};
    const ModelScore msac = kernels().residuals.score[number](model, m, rule);
    EXPECT_EQ(msac.inliers, inliers);
    EXPECT_EQ(msac.seen, 777u);
    EXPECT_NEAR(double(msac.cost) / ScoreRule::kOutlierCost, cost, 0.02);
    EXPECT_GT(inliers, 50u);
    rule.cost_per_error = 0;
    EXPECT_EQ(kernels().residuals.score[number](model, m, rule).cost,
              std::int64_t(777 - inliers) * ScoreRule::kOutlierCost);
  }
}

TEST_F(Kernels, NormalEquationsAreThoseOfTheInliersAtEveryLevel) {
  const Scene plane = homographyScene({2503, 0.5, 2.0, 6}), space = stereoScene({2503, 0.5, 2.0, 6});
  for (const Residual residual : kEveryResidual) {
    const auto number = static_cast<std::size_t>(residual);
    const bool fundamental = residual == Residual::kSampson;
    NormalizedMatches m = normalizeMatches((fundamental ? space : plane).matches);
    ResidualModel model = residualModel(residual, fundamental ? m.right.inv().t() * space.model * m.left.inv()
                                                              : m.right * plane.model * m.left.inv());
    const auto threshold = static_cast<float>(9 * m.scale * m.scale);
    std::vector<float> errors(m.size());
    kernels().residuals.errors[number](model, m.columns(), 0, m.size(), errors.data());
    std::vector<double> expected(fundamental ? kFundamentalSums : kHomographySums, 0.0);
    std::size_t inliers = 0;
    for (std::size_t i = 0; i < m.size(); ++i) {
      if (errors[i] > threshold) continue;
      ++inliers;
      const double x = m.left_x[i], y = m.left_y[i], u = m.right_x[i], v = m.right_y[i];
      const float* const f = model.forward;
      const double a = f[0] * x + f[1] * y + f[2], b = f[3] * x + f[4] * y + f[5],
                   w = f[6] * x + f[7] * y + f[8];
      if (fundamental) {
        const double c = f[0] * u + f[3] * v + f[6], d = f[1] * u + f[4] * v + f[7];
        const double p[3] = {x, y, 1}, q[3] = {u, v, 1}, g = a * a + b * b + c * c + d * d;
        std::size_t k = 0;
        for (int r = 0; r < 3; ++r)
          for (int s = r; s < 3; ++s)
            for (int t = 0; t < 3; ++t)
              for (int z = t; z < 3; ++z) expected[k++] += q[r] * q[s] * p[t] * p[z] / g;
        continue;
      }
      const double p[3] = {x / w, y / w, 1 / w}, hx = a / w, hy = b / w;
      std::size_t k = 0;
      for (int r = 0; r < 3; ++r) {
        for (int s = r; s < 3; ++s, ++k) {
          expected[k] += p[r] * p[s];
          expected[6 + k] += hx * p[r] * p[s];
          expected[12 + k] += hy * p[r] * p[s];
          expected[18 + k] += (hx * hx + hy * hy) * p[r] * p[s];
        }
        expected[24 + std::size_t(r)] += p[r] * (u - hx);
        expected[27 + std::size_t(r)] += p[r] * (v - hy);
        expected[30 + std::size_t(r)] += p[r] * (hx * (u - hx) + hy * (v - hy));
      }
    }
    EXPECT_GT(inliers, 400u);
    setKernelLevel(KernelLevel::kPlain);
    std::vector<double> plain(expected.size());
    kernels().residuals.normal[number](model, m.columns(), threshold, plain.data());
    for (std::size_t k = 0; k < expected.size(); ++k)
      EXPECT_NEAR(plain[k], expected[k], 1e-5 * double(inliers)) << number << " sum " << k;
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      std::vector<double> sums(expected.size());
      kernels().residuals.normal[number](model, m.columns(), threshold, sums.data());
      EXPECT_EQ(sums, plain) << toString(level);
    }
  }
}

TEST_F(Kernels, FirstColumnOfTheFieldIsTheExponentialFunctionAtEveryLevel) {
  constexpr std::size_t kPadded = 37 * kFieldGroup;
  std::vector<double> x(kPadded), y(kPadded, 0.0);
  for (std::size_t i = 0; i < kPadded; ++i) x[i] = 0.09 * double(i);  // x^2 from 0 to 705
  const double origin = 0, whole_diagonal = 1;
  const FieldPivots pivot = {1, &origin, &origin, &whole_diagonal, nullptr, 0};
  const FieldFactor nothing = {nullptr, kPadded, 0, kPadded};
  std::vector<double> first;
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    std::vector<double> added(kPadded), rest(kPadded, 1.0);
    const double largest =
        kernels().field.factor(x.data(), y.data(), 1, pivot, nothing, added.data(), rest.data());
    for (std::size_t i = 0; i < kPadded; ++i) {
      const double expected = std::exp(-std::min(x[i] * x[i], 700.0));
      EXPECT_NEAR(added[i], expected, 1e-15 * expected) << toString(level) << ", x = " << x[i];
      EXPECT_EQ(rest[i], 1 - added[i] * added[i]) << toString(level) << ", x = " << x[i];
    }
    EXPECT_EQ(largest, 1);
    if (first.empty()) first = added;
    EXPECT_EQ(added, first) << toString(level);
  }
}

TEST_F(Kernels, GramMatrixIsTheSumOfWeightedProductsAtEveryRankAndLevel) {
  constexpr std::size_t kPadded = 37 * kFieldGroup;
  for (std::size_t rank = 0; rank <= 11; ++rank) {
    const std::size_t columns = rank + 2;
    Random random(rank);
    std::vector<double> values(columns * kPadded), weight(kPadded);
    for (double& value : values) value = random.uniform() - 0.5;
    for (double& w : weight) w = random.uniform();
    const FieldFactor factor = {values.data(), kPadded, rank, kPadded};
    std::vector<double> first;
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      std::vector<double> lanes(columns * columns * kFieldGroup), gram(columns * columns);
      kernels().field.gram(factor, weight.data(), lanes.data(), gram.data());
      for (std::size_t j = 0; j < columns; ++j) {
        for (std::size_t k = j; k < columns; ++k) {
          double expected = 0;
          for (std::size_t i = 0; i < kPadded; ++i) {
            expected += weight[i] * values[j * kPadded + i] * values[k * kPadded + i];
          }
          EXPECT_NEAR(gram[j * columns + k], expected, 1e-12)
              << toString(level) << ", rank " << rank << ", element " << j << ", " << k;
        }
        for (std::size_t k = 0; k < j; ++k) gram[j * columns + k] = 0;  // undefined
      }
      if (first.empty()) first = gram;
      EXPECT_EQ(gram, first) << toString(level) << ", rank " << rank;
    }
  }
}

TEST_F(Kernels, SprtRejectsAWrongModelEarlyAndKeepsARightOne) {
  const Scene scene = homographyScene({2000, 0.5, 0.5, 7});
  Correspondences mixed = scene.matches.subset(permutation(2000, 3));
  ResidualModel model = modelOf(Residual::kTransfer, scene, scene);
  ScoreRule rule{9.0F, 0.0F, std::numeric_limits<std::int64_t>::max()};
  rule.log_consistent = std::log(0.01 / 0.4);
  rule.log_inconsistent = std::log(0.99 / 0.6);
  rule.log_decision = std::log(20.0);
  const ModelScore right = kernels().residuals.score[0](model, columns(mixed, 2000), rule);
  EXPECT_FALSE(right.rejected);
  EXPECT_EQ(right.seen, 2000u);
  EXPECT_GE(right.inliers, 990u);
  model.forward[2] += 100;
  const ModelScore wrong = kernels().residuals.score[0](model, columns(mixed, 2000), rule);
  EXPECT_TRUE(wrong.rejected_by_sprt);
  EXPECT_LE(wrong.seen, 64u);
}

TEST_F(Kernels, SupportIsTheSameAtEveryLevel) {
  const Scene scene = homographyScene({1008, 0.5, 2.0, 9});
  const Correspondences& all = scene.matches;
  std::vector<std::int32_t> weight(all.size());
  for (std::size_t i = 0; i < weight.size(); ++i)
    weight[i] = i % 50 == 0 ? 0 : 4096 / std::int32_t(1 + i % 7);
  const VotingMatches m = {all.left_x.data(), all.left_y.data(), all.right_x.data(), all.right_y.data(),
                           weight.data()};
  const SupportRule rule = {{100 * 100, 250 * 250}, {0.12F * 0.12F, 0.3F * 0.3F}, 9};
  const SupportRun cases[][3] = {{{0, 1008}, {0, 0}, {0, 0}}, {{0, 16}, {32, 48}, {992, 1008}}, {}};
  for (const auto& runs : cases) {
    for (const std::size_t i : {0, 3, 40, 700}) {
      const LocalMap map = {0.9F,          -0.15F,        0.12F,          0.95F,
                            all.left_x[i], all.left_y[i], all.right_x[i], all.right_y[i]};
      SupportCounts expected{};
      std::int32_t around[2] = {};
      for (const SupportRun& run : runs) {
        for (std::size_t j = run.begin; j < run.end; ++j) {
          const float dx = all.left_x[j] - map.x, dy = all.left_y[j] - map.y;
          const float vx = all.right_x[j] - map.u, vy = all.right_y[j] - map.v;
          const float ux = map.a11 * dx + map.a12 * dy, uy = map.a21 * dx + map.a22 * dy;
          const float uu = ux * ux + uy * uy, vv = vx * vx + vy * vy;
          const float ee = (vx - ux) * (vx - ux) + (vy - uy) * (vy - uy);
          for (int r = 0; r < 2; ++r) {
            if (vv > 9 && vv <= rule.squared_radius[r]) around[r] += weight[j];
            if (uu <= 9 || vv <= 9 || uu > rule.squared_radius[r]) continue;
            expected.left[r] += weight[j];
            for (int t = 0; t < 2; ++t) {
              if (ee <= std::max(9.0F, uu * rule.squared_rho[t])) expected.supporters[r][t] += weight[j];
            }
          }
        }
      }
      if (runs[0].end == 1008 && scene.inlier[i]) {
        EXPECT_GT(expected.supporters[0][0], 4096);
        EXPECT_LT(expected.supporters[0][0], expected.supporters[0][1]);
        EXPECT_LT(expected.supporters[1][1], expected.left[1]);
      }
      for (const KernelLevel level : supportedKernelLevels()) {
        SCOPED_TRACE(toString(level));
        setKernelLevel(level);
        SupportCounts both{}, first{};
        kernels().support.both(m, runs, 3, map, rule, both);
        kernels().support.first(m, runs, 3, map, rule, first);
        for (int r = 0; r < 2; ++r) {
          EXPECT_EQ(both.left[r], expected.left[r]);
          for (int t = 0; t < 2; ++t) EXPECT_EQ(both.supporters[r][t], expected.supporters[r][t]);
        }
        EXPECT_EQ(first.left[0], expected.left[0]);
        EXPECT_EQ(first.supporters[0][0], expected.supporters[0][0]);
        std::int32_t counts[2] = {};
        kernels().support.around_both(m, runs, 3, map.u, map.v, rule, counts);
        EXPECT_EQ(counts[0], around[0]);
        EXPECT_EQ(counts[1], around[1]);
        kernels().support.around_first(m, runs, 3, map.u, map.v, rule, counts);
        EXPECT_EQ(counts[0], around[0]);
      }
    }
  }
}

TEST_F(Kernels, GainsOfAffineMapsAreSumsInOrder) {
  const Scene scene = homographyScene({301, 0.5, 2.0, 9});
  const Correspondences& all = scene.matches;
  const MatchColumns m = {all.left_x.data(), all.left_y.data(), all.right_x.data(), all.right_y.data(),
                          all.size()};
  AffineMaps maps{};
  float expected[AffineMaps::kMaps];
  for (std::size_t k = 0; k < AffineMaps::kMaps; ++k) {
    const float s = 0.9F + 0.01F * static_cast<float>(k);
    const float map[6] = {s, -0.1F, 5, 0.1F, s, static_cast<float>(k)};
    for (std::size_t i = 0; i < 6; ++i) maps.m[i][k] = map[i];
    expected[k] = 0;
    for (std::size_t j = 0; j < all.size(); ++j) {
      const float ex = map[0] * all.left_x[j] + map[1] * all.left_y[j] + map[2] - all.right_x[j];
      const float ey = map[3] * all.left_x[j] + map[4] * all.left_y[j] + map[5] - all.right_y[j];
      expected[k] += std::max(0.0F, 1.0F - (ex * ex + ey * ey) * 1e-4F);
    }
    EXPECT_GT(expected[k], 0);
  }
  for (const KernelLevel level : supportedKernelLevels()) {
    SCOPED_TRACE(toString(level));
    setKernelLevel(level);
    float gains[AffineMaps::kMaps];
    kernels().support.affine_gains(maps, m, 1e-4F, gains);
    for (std::size_t k = 0; k < AffineMaps::kMaps; ++k) EXPECT_EQ(gains[k], expected[k]) << k;
  }
}

TEST_F(Kernels, AffineCountsAreTheSameAtEveryLevel) {
  const Scene scene = homographyScene({1008, 0.5, 2.0, 9});
  const Correspondences& m = scene.matches;
  const float a[] = {0.9F, -0.1F, 0.2F, 1.1F};
  for (const std::size_t slots : {0, 16, 32, 1008}) {
    std::int32_t expected[2] = {};
    const float limits[] = {150 * 150, 300 * 300};
    for (std::size_t i = 0; i < slots; ++i) {
      const float ex = a[0] * m.left_x[i] + a[1] * m.left_y[i] - m.right_x[i];
      const float ey = a[2] * m.left_x[i] + a[3] * m.left_y[i] - m.right_y[i];
      for (int k = 0; k < 2; ++k) expected[k] += ex * ex + ey * ey <= limits[k] ? 1 : 0;
    }
    if (slots == 1008) {
      EXPECT_GT(expected[0], 10);
      EXPECT_LT(expected[0], expected[1]);
      EXPECT_LT(expected[1], 1008);
    }
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      const RelativeMatches relative = {m.left_x.data(), m.left_y.data(), m.right_x.data(), m.right_y.data(),
                                        slots};
      for (int k = 0; k < 2; ++k)
        EXPECT_EQ(kernels().affine.count(relative, a, limits[k]), expected[k])
            << toString(level) << " " << slots;
    }
  }
}

TEST_F(Kernels, MatchesAroundASeedAreTheSameAtEveryLevel) {
  const Correspondences m = homographyScene({1000, 0.5, 2.0, 9}).matches;
  constexpr std::size_t kBehind = FramedMatches::kMultiple;
  std::vector<float> values[7];
  Random random(4);
  for (std::size_t i = 0; i < m.size() + kBehind; ++i) {
    const bool inside = i < m.size();
    const double angle = random.uniform(-0.6, 0.6), scale = random.uniform(-0.6, 0.6);
    const float no_map = std::numeric_limits<float>::quiet_NaN();
    values[0].push_back(inside ? m.left_x[i] : 0);
    values[1].push_back(inside ? m.left_y[i] : 0);
    values[2].push_back(inside ? m.right_x[i] : 0);
    values[3].push_back(inside ? m.right_y[i] : 0);
    values[4].push_back(i % 11 == 0 ? no_map : float(std::cos(angle)));
    values[5].push_back(float(std::sin(angle)));
    values[6].push_back(float(scale));
  }
  const FramedMatches matches = {values[0].data(), values[1].data(), values[2].data(), values[3].data(),
                                 values[4].data(), values[5].data(), values[6].data()};
  const FramedReach reach = {400, 300, 400, 300, 1, 0, 0, 250 * 250, 350 * 350, 0.9F, 0.4F};
  for (const auto& [begin, end] :
       {std::pair<std::uint32_t, std::uint32_t>{0, 1000}, {5, 5}, {7, 20}, {3, 998}}) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = begin; i < end; ++i) {
      const double left = std::hypot(values[0][i] - 400, values[1][i] - 300);
      const double right = std::hypot(values[2][i] - 400, values[3][i] - 300);
      if (left < 250 && right < 350 && values[4][i] >= 0.9F && std::abs(values[6][i]) <= 0.4F)
        expected.push_back(i);
    }
    if (end - begin > 900) {
      EXPECT_GT(expected.size(), 20U);
      EXPECT_LT(expected.size(), 500U);
    }
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      std::vector<std::uint32_t> found(end - begin + kBehind);
      found.resize(kernels().affine.around(matches, begin, end, reach, found.data()));
      EXPECT_EQ(found, expected) << toString(level) << " " << begin << " " << end;
    }
  }
}

TEST_F(Kernels, SupportersOfAMapAreTheSameAtEveryLevel) {
  for (const std::size_t n : {1, 15, 16, 17, 1003}) {
    const Correspondences m = homographyScene({n, 0.6, 2.0, 9}).matches;
    GrowingMap map{};
    const float p[] = {0.98F, 0.1F, -0.1F, 0.97F, 1, -2};
    std::copy(std::begin(p), std::end(p), map.p);
    map.left_x = m.left_x[0];
    map.left_y = m.left_y[0];
    map.right_x = m.right_x[0];
    map.right_y = m.right_y[0];
    map.squared_radius = 400 * 400;
    map.squared_rho = 0.25F;
    map.squared_floor = 16;
    std::vector<std::uint32_t> expected;
    std::vector<float> tolerances;
    for (std::uint32_t i = 0; i < n; ++i) {
      const float dx = m.left_x[i] - m.left_x[0], dy = m.left_y[i] - m.left_y[0];
      const float ux = p[0] * dx + p[2] * dy + p[4], uy = p[1] * dx + p[3] * dy + p[5];
      const float ex = m.right_x[i] - m.right_x[0] - ux, ey = m.right_y[i] - m.right_y[0] - uy;
      const float length = ux * ux + uy * uy, tolerance = std::max(16.0F, 0.25F * length);
      if (!(length <= 400 * 400 && ex * ex + ey * ey <= tolerance)) continue;
      expected.push_back(i);
      tolerances.push_back(tolerance);
    }
    if (n > 1000) {
      EXPECT_GT(expected.size(), 50U);
      EXPECT_LT(expected.size(), 800U);
    }
    for (const KernelLevel level : supportedKernelLevels()) {
      SCOPED_TRACE(toString(level) + " " + std::to_string(n));
      setKernelLevel(level);
      std::vector<std::uint32_t> found(n + SupportKernels::kMaxVectorLength);
      std::vector<float> found_tolerances(found.size());
      const std::size_t count =
          kernels().support.supporters(columns(m, n), map, found.data(), found_tolerances.data());
      found.resize(count);
      found_tolerances.resize(count);
      EXPECT_EQ(found, expected);
      EXPECT_EQ(found_tolerances, tolerances);
    }
  }
}

/// test_lap compares the costs with their definition.
TEST_F(Kernels, CostsOfAreaRatiosAreTheSameAtEveryLevel) {
  constexpr std::uint32_t kMatches = 77;
  Correspondences m = homographyScene({kMatches, 0.6, 1.0, 9}).matches;
  // Triangles without an area, and equal motions.
  for (std::size_t i = 0; i < 8; ++i) {
    m.left_y[i] = m.left_x[i];
    m.right_x[i] = m.left_x[i] + 20;
    m.right_y[i] = m.left_y[i];
  }
  static SaturationTable table{};
  for (int i = 0; i < SaturationTable::kEntries; ++i) {
    const auto value = [](int k) { return float(1 - std::exp(-k / double{SaturationTable::kPerUnit})); };
    table.values[2 * i] = value(i);
    table.values[2 * i + 1] = value(i + 1) - value(i);
  }
  for (const auto& [candidates, neighbours] : {std::pair<int, int>{25, 10}, {4, 3}, {60, 20}}) {
    const int triples = neighbours * (neighbours - 1) * (neighbours - 2) / 6;
    for (const int kept : {1, (triples + 1) / 2, triples}) {
      const AreaRatioRule rule = {candidates, neighbours, kept, 25, &table};
      std::vector<std::uint32_t> lists;
      for (std::uint32_t i = 0; i < kMatches; ++i) {
        for (std::uint32_t k = 1; k <= std::uint32_t(candidates); ++k) lists.push_back((i + k) % kMatches);
      }
      std::vector<float> expected, scratch(rule.scratchSize());
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        std::vector<float> costs(kMatches);
        kernels().area_ratio.costs(columns(m, kMatches), lists.data(), std::size_t(candidates), rule,
                                   scratch.data(), costs.data());
        if (expected.empty()) expected = costs;
        EXPECT_EQ(costs, expected) << toString(level) << " " << candidates << " " << kept;
        EXPECT_GE(*std::min_element(costs.begin(), costs.end()), 0);
        EXPECT_LE(*std::max_element(costs.begin(), costs.end()), 3);
        EXPECT_LT(*std::min_element(costs.begin(), costs.end()),
                  *std::max_element(costs.begin(), costs.end()));
      }
    }
  }
}

TEST_F(Kernels, PointsBehindTheCameraHaveNoError) {
  const float x[] = {1}, y[] = {1};
  const MatchColumns m = {x, y, x, y, 1};
  const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, behind[9] = {1, 0, 0, 0, 1, 0, -1, 0, 0.5};
  for (const Residual residual :
       {Residual::kTransfer, Residual::kSymmetricTransfer, Residual::kSmallerTransfer}) {
    // Behind either camera, where that direction counts.
    for (const bool forward : {true, false}) {
      ResidualModel model{};
      std::copy(forward ? behind : identity, (forward ? behind : identity) + 9, model.forward);
      std::copy(forward ? identity : behind, (forward ? identity : behind) + 9, model.backward);
      float error = 0;
      kernels().residuals.errors[static_cast<std::size_t>(residual)](model, m, 0, 1, &error);
      EXPECT_EQ(std::isinf(error), forward || residual != Residual::kTransfer);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
