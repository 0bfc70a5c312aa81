#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "base/text.h"
#include "corrsel/selectors/vfc.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

Eigen::MatrixX2d normalised(const std::vector<float>& x, const std::vector<float>& y) {
  Eigen::MatrixX2d points(x.size(), 2);
  for (std::size_t i = 0; i < x.size(); ++i) points.row(Eigen::Index(i)) << x[i], y[i];
  points.rowwise() -= points.colwise().mean().eval();
  return points / std::sqrt(points.rowwise().squaredNorm().mean());
}

struct Answer {
  Mask mask;
  std::vector<double> posterior;
  int iterations = 0;
};

/// VFC as it is defined, with the whole kernel matrix and dense solves.
Answer byDefinition(const Correspondences& m, const VfcOptions& o = {}) {
  const Eigen::MatrixX2d points = normalised(m.left_x, m.left_y);
  const Eigen::MatrixX2d samples = normalised(m.right_x, m.right_y) - points;
  const Eigen::Index n = points.rows();
  Eigen::MatrixXd kernel(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    kernel.col(i) =
        (-o.beta * (points.rowwise() - points.row(i)).rowwise().squaredNorm().array()).exp().matrix();
  }
  Eigen::MatrixX2d field = Eigen::MatrixX2d::Zero(n, 2), weights = field;
  Eigen::VectorXd p(n);
  double variance = samples.squaredNorm() / double(2 * n), gamma = o.inlier_ratio, energy = 1;
  Answer answer;
  while (answer.iterations < o.max_iterations && variance > 1e-8) {
    ++answer.iterations;
    const Eigen::ArrayXd squared = (samples - field).rowwise().squaredNorm();
    const Eigen::ArrayXd e = (-squared / (2 * variance)).exp();
    p = e / (e + 2 * M_PI * variance * (1 - gamma) / (gamma * o.outlier_area));
    const double old = energy;
    energy = p.dot(squared.matrix()) / (2 * variance) + p.sum() * std::log(variance) +
             o.lambda / 2 * weights.cwiseProduct(kernel * weights).sum();
    if (std::abs(energy - old) <= o.energy_change * std::abs(energy)) break;
    const Eigen::VectorXd clamped = p.cwiseMax(1e-5);
    Eigen::MatrixXd system = kernel;
    system.diagonal() += o.lambda * variance * clamped.cwiseInverse();
    weights = system.llt().solve(samples);
    field = kernel * weights;
    variance = clamped.dot((samples - field).rowwise().squaredNorm()) / (2 * clamped.sum());
    gamma = std::clamp(double((p.array() > o.threshold).count()) / double(n), 0.05, 0.95);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    answer.mask.push_back(p[i] > o.threshold ? 1 : 0);
    answer.posterior.push_back(std::max(p[i], 1e-5));
  }
  return answer;
}

std::size_t differences(const Mask& a, const Mask& b) {
  std::size_t count = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
  return count;
}

/// Restores the kernel level that was in use.
class Vfc : public ::testing::Test {
 protected:
  ~Vfc() override { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

TEST_F(Vfc, FollowsTheDefinition) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const SceneOptions scene{61 + 41 * seed, 0.25 + 0.06 * double(seed), 0.4 * double(seed % 4), seed};
    const Correspondences m = (seed % 2 ? stereoScene(scene) : homographyScene(scene)).matches;
    VfcOptions options;
    if (seed > 7) {
      options.beta = 0.5;
      options.lambda = 1;
      options.threshold = 0.6;
      options.inlier_ratio = 0.5;
      options.outlier_area = 5;
      options.max_iterations = 8;
    }
    const Answer expected = byDefinition(m, options);
    const Selection s = VfcSelector(options).select(m);
    EXPECT_EQ(s.mask, expected.mask) << seed;
    EXPECT_EQ(s.iterations, expected.iterations) << seed;
    EXPECT_GT(s.n_selected, 0u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
    options.kernel_tolerance = 0;
    const Selection exact = VfcSelector(options).select(m);
    ASSERT_EQ(exact.score.size(), expected.posterior.size());
    for (std::size_t i = 0; i < m.size(); ++i) {
      ASSERT_NEAR(s.score[i], expected.posterior[i], 5e-3) << seed << " " << i;
      ASSERT_NEAR(exact.score[i], expected.posterior[i], 1e-5) << seed << " " << i;
    }
  }
}

/// SparseVFC as it is defined, on given control points.
Mask sparseByDefinition(const Correspondences& m, Eigen::Index points, std::uint64_t seed) {
  const Eigen::MatrixX2d x = normalised(m.left_x, m.left_y), y = normalised(m.right_x, m.right_y) - x;
  std::vector<std::uint32_t> drawn(static_cast<std::size_t>(points));
  Random(seed).sample(std::uint32_t(m.size()), drawn.size(), drawn.data());
  Eigen::MatrixXd u(x.rows(), points), g(points, points);
  for (Eigen::Index j = 0; j < points; ++j) {
    const auto row = Eigen::Index(drawn[std::size_t(j)]);
    u.col(j) = (-0.1 * (x.rowwise() - x.row(row)).rowwise().squaredNorm().array()).exp().matrix();
  }
  for (Eigen::Index j = 0; j < points; ++j) g.row(j) = u.row(Eigen::Index(drawn[std::size_t(j)]));
  Eigen::MatrixX2d field = Eigen::MatrixX2d::Zero(x.rows(), 2), c = Eigen::MatrixX2d::Zero(points, 2);
  Eigen::VectorXd p(x.rows());
  double variance = y.squaredNorm() / double(2 * x.rows()), gamma = 0.9, energy = 1;
  while (variance > 1e-8) {
    const Eigen::VectorXd squared = (y - field).rowwise().squaredNorm();
    const Eigen::ArrayXd e = (-squared / (2 * variance)).array().exp();
    p = e / (e + 2 * M_PI * variance * (1 - gamma) / (gamma * 10));
    const double old = energy;
    energy =
        p.dot(squared) / (2 * variance) + p.sum() * std::log(variance) + 1.5 * c.cwiseProduct(g * c).sum();
    if (std::abs(energy - old) <= 1e-5 * std::abs(energy)) break;
    const Eigen::VectorXd w = p.cwiseMax(1e-5);
    const Eigen::MatrixXd weighted = w.asDiagonal() * u;
    c = (weighted.transpose() * u + 3 * variance * g).ldlt().solve(weighted.transpose() * y);
    field = u * c;
    variance = w.dot((y - field).rowwise().squaredNorm()) / (2 * w.sum());
    gamma = std::clamp(double((p.array() > 0.75).count()) / double(x.rows()), 0.05, 0.95);
  }
  Mask mask;
  for (Eigen::Index i = 0; i < p.size(); ++i) mask.push_back(p(i) > 0.75 ? 1 : 0);
  return mask;
}

TEST_F(Vfc, SparseFollowsItsDefinition) {
  for (const int seed : {0, 1, 2, 3}) {
    const Scene scene = homographyScene({400, 0.5, 1.0, 5 + std::uint64_t(seed)});
    // In the order of the left points, which is the order that control points are drawn from.
    std::vector<std::uint32_t> order = permutation(400, 1);
    std::sort(order.begin(), order.end(), [&scene](std::uint32_t a, std::uint32_t b) {
      return scene.matches.left_x[a] < scene.matches.left_x[b];
    });
    const Correspondences m = scene.matches.subset(order);
    const auto selector = createSelector("vfc:sparse", {{"seed", std::to_string(seed)}});
    EXPECT_LE(differences(selector->select(m).mask, sparseByDefinition(m, 16, std::uint64_t(seed))), 1u);
  }
}

TEST_F(Vfc, AnswersAlikeAtEveryKernelLevel) {
  for (const std::size_t n : {5, 8, 31, 130, 777}) {
    const Correspondences m = homographyScene({n, 0.6, 1.0, 3}).matches;
    for (const char* spec : {"vfc", "vfc:sparse"}) {
      setKernelLevel(KernelLevel::kPlain);
      const Selection expected = createSelector(spec)->select(m);
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        const Selection s = createSelector(spec)->select(m);
        EXPECT_EQ(s.score, expected.score) << toString(level) << " " << n << " " << spec;
        EXPECT_EQ(s.mask, expected.mask) << toString(level);
        EXPECT_EQ(s.iterations, expected.iterations) << toString(level);
      }
    }
  }
}

void scaleAndShift(std::vector<float>& column, float scale, float shift) {
  for (float& value : column) value = value * scale + shift;
}

TEST_F(Vfc, TranslationAndScaleOfEitherImageCancel) {
  const Correspondences m = homographyScene({700, 0.5, 0.7, 9}).matches;
  for (const char* spec : {"vfc", "vfc:sparse"}) {
    const auto selector = createSelector(spec);
    const Selection expected = selector->select(m);
    for (const bool left : {true, false}) {
      for (const float scale : {0.25f, 8.0f, 1.7f, 0.3f}) {
        Correspondences changed = m;
        const float shift = scale == 1.7f || scale == 0.3f ? 123.4f : 0.0f;
        scaleAndShift(left ? changed.left_x : changed.right_x, scale, shift);
        scaleAndShift(left ? changed.left_y : changed.right_y, scale, -shift);
        const Selection s = selector->select(changed);
        EXPECT_EQ(s.mask, expected.mask) << spec << " " << left << " " << scale;
        if (shift == 0) {
          EXPECT_EQ(s.score, expected.score) << spec << " " << left << " " << scale;
        }
      }
    }
  }
}

TEST_F(Vfc, PermutedMatchesArePermutedAnswers) {
  const Correspondences m = stereoScene({900, 0.6, 0.7, 2}).matches;
  for (const char* spec : {"vfc", "vfc:sparse"}) {
    const Selection expected = createSelector(spec)->select(m);
    for (const std::uint64_t seed : {1, 2, 3}) {
      const std::vector<std::uint32_t> order = permutation(m.size(), seed);
      const Selection s = createSelector(spec)->select(m.subset(order));
      EXPECT_EQ(s.score, reordered(expected.score, order));
      EXPECT_EQ(s.iterations, expected.iterations);
    }
  }
}

TEST_F(Vfc, AcceptsWhatRestsWhereNothingMoves) {
  Correspondences m = homographyScene({400, 1.0, 0.0, 4}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  scaleAndShift(m.right_x, 2, 30);
  scaleAndShift(m.right_y, 2, -40);
  const Selection all = VfcSelector().select(m);
  EXPECT_EQ(all.mask, Mask(400, 1));
  EXPECT_EQ(all.iterations, 0);
  m.right_x[17] += 1;  // 0.5 px of a spread of some 300 px, the others follow by a four-hundredth of it
  const Selection s = VfcSelector().select(m);
  EXPECT_EQ(s.iterations, 0);
  EXPECT_EQ(s.n_selected, 399u);
  EXPECT_EQ(s.mask[17], 0);
}

TEST_F(Vfc, FindsAnAffineField) {
  Scene scene = homographyScene({600, 0.5, 0.0, 8});
  for (std::size_t i = 0; i < 600; ++i) {
    const float x = scene.matches.left_x[i], y = scene.matches.left_y[i];
    if (!scene.inlier[i]) continue;
    scene.matches.right_x[i] = 0.95f * x + 0.1f * y + 20;
    scene.matches.right_y[i] = -0.05f * x + 1.05f * y - 10;
  }
  for (const char* spec : {"vfc", "vfc:sparse"}) {
    const Quality q = quality(createSelector(spec)->select(scene.matches).mask, scene.inlier);
    EXPECT_GT(q.precision, 97) << spec;
    EXPECT_GT(q.recall, 99) << spec;
  }
}

TEST_F(Vfc, SelectsLittleWhereAllIsWrong) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene = homographyScene({1000, 0.0, 0.0, seed});
    EXPECT_LT(VfcSelector().select(scene.matches).n_selected, 100u) << seed;
  }
}

TEST_F(Vfc, FewPointsFarOutDoNoHarm) {
  Scene scene = homographyScene({600, 0.5, 0.5, 6});
  for (std::size_t i = 590; i < 600; ++i)
    scene.matches.left_x[i] = float(i % 2 ? 9000 : -6000) + 300 * float(i);
  const Selection s = VfcSelector().select(scene.matches);
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(s.mask, byDefinition(scene.matches).mask);
}

TEST_F(Vfc, NamesWhatItCannotDecide) {
  Correspondences m = homographyScene({4, 1.0, 0.0, 1}).matches;
  EXPECT_EQ(VfcSelector().select(m).status, Status::kTooFew);
  EXPECT_EQ(VfcSelector().select(m).message, "4 matches, vfc needs 5");
  m = homographyScene({50, 1.0, 0.0, 1}).matches;
  m.right_x.assign(50, 3.0f);
  m.right_y.assign(50, 4.1f);
  const Selection s = VfcSelector().select(m);
  EXPECT_EQ(s.status, Status::kDegenerate);
  EXPECT_EQ(s.message, "all points of an image are equal");
  EXPECT_EQ(s.mask, Mask(50, 0));
}

TEST_F(Vfc, StopsAtTheTimeLimit) {
  const Correspondences m = homographyScene({5000, 0.05, 0.5, 3}).matches;
  for (const int control_points : {0, 16, 200}) {
    SCOPED_TRACE(control_points);
    VfcOptions options;
    options.control_points = control_points;
    options.energy_change = 0;
    options.max_iterations = 10000;
    // Longer and longer, until it is long enough for one step.
    Selection s;
    for (options.max_seconds = 0.5; s.iterations == 0; options.max_seconds += 1) {
      ASSERT_LT(options.max_seconds, 1000);
      SCOPED_TRACE(options.max_seconds);
      const TickingClock clock(1);
      s = VfcSelector(options).select(m);
      EXPECT_LE(clock.looks(), options.max_seconds + 3);
      if (s.iterations > 0) break;
      EXPECT_EQ(s.status, Status::kTooLarge);
      EXPECT_EQ(s.message, "stopped after 0 steps, max_seconds = " + formatNumber(options.max_seconds));
      EXPECT_EQ(s.mask, Mask(5000, 0));
      EXPECT_TRUE(s.score.empty());
    }
    EXPECT_GT(options.max_seconds, 1) << "no time for a step";
    EXPECT_EQ(s.status, Status::kTimeLimit);
    EXPECT_GE(s.iterations, 1);
    EXPECT_EQ(s.message, "stopped after " + std::to_string(s.iterations) +
                             " steps, max_seconds = " + formatNumber(options.max_seconds));
    // The posteriors are those that the next step begins with.
    options.max_seconds = 0;
    options.max_iterations = s.iterations + 1;
    const Selection counted = VfcSelector(options).select(m);
    EXPECT_EQ(counted.iterations, s.iterations + 1);
    EXPECT_EQ(counted.mask, s.mask);
    EXPECT_EQ(counted.score, s.score);
  }
}

TEST_F(Vfc, LimitsThatAreNotReachedChangeNothing) {
  const Correspondences m = homographyScene({1000, 0.4, 0.5, 3}).matches;
  VfcOptions options;
  const Selection without = VfcSelector(options).select(m);
  options.max_seconds = 1000;
  const Selection with = VfcSelector(options).select(m);
  EXPECT_EQ(with.status, Status::kOk);
  EXPECT_EQ(with.message, "");
  EXPECT_EQ(with.mask, without.mask);
  EXPECT_EQ(with.score, without.score);
  EXPECT_EQ(with.iterations, without.iterations);
}

/// The field of `fitted` rows is evaluated at all rows, with dense kernel matrices.
Mask guidedByDefinition(const Correspondences& m, const std::vector<std::uint32_t>& fitted,
                        const VfcOptions& o) {
  const auto points = [&m](const std::vector<std::uint32_t>& rows, bool left) {
    Eigen::MatrixX2d p(rows.size(), 2);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      p.row(Eigen::Index(i)) << (left ? m.left_x : m.right_x)[rows[i]],
          (left ? m.left_y : m.right_y)[rows[i]];
    }
    return p;
  };
  std::vector<std::uint32_t> all(m.size());
  std::iota(all.begin(), all.end(), 0U);
  Eigen::MatrixX2d x = points(fitted, true), y = points(fitted, false), all_x = points(all, true),
                   all_y = points(all, false);
  double right_scale = 0;
  for (const auto& [few, many] : {std::pair{&x, &all_x}, std::pair{&y, &all_y}}) {
    const Eigen::RowVector2d mean = few->colwise().mean();
    few->rowwise() -= mean;
    many->rowwise() -= mean;
    right_scale = 1 / std::sqrt(few->rowwise().squaredNorm().mean());
    *few *= right_scale;
    *many *= right_scale;
  }
  y -= x;
  all_y -= all_x;
  const auto kernel = [&o](const Eigen::MatrixX2d& a, const Eigen::MatrixX2d& b) {
    Eigen::MatrixXd k(a.rows(), b.rows());
    for (Eigen::Index j = 0; j < b.rows(); ++j)
      k.col(j) = (-o.beta * (a.rowwise() - b.row(j)).rowwise().squaredNorm().array()).exp().matrix();
    return k;
  };
  const Eigen::Index n = x.rows();
  const Eigen::MatrixXd k = kernel(x, x);
  Eigen::MatrixX2d weights = Eigen::MatrixX2d::Zero(n, 2), field = weights;
  double variance = y.squaredNorm() / double(2 * n), gamma = o.inlier_ratio, energy = 1;
  for (int step = 0; step < o.max_iterations && variance > 1e-8; ++step) {
    const Eigen::ArrayXd squared = (y - field).rowwise().squaredNorm();
    const Eigen::ArrayXd e = (-squared / (2 * variance)).exp();
    const Eigen::VectorXd p = e / (e + 2 * M_PI * variance * (1 - gamma) / (gamma * o.outlier_area));
    const double old = energy;
    energy = p.dot(squared.matrix()) / (2 * variance) + p.sum() * std::log(variance) +
             o.lambda / 2 * weights.cwiseProduct(k * weights).sum();
    if (std::abs(energy - old) <= o.energy_change * std::abs(energy)) break;
    const Eigen::VectorXd clamped = p.cwiseMax(1e-5);
    Eigen::MatrixXd system = k;
    system.diagonal() += o.lambda * variance * clamped.cwiseInverse();
    weights = system.llt().solve(y);
    field = k * weights;
    variance = clamped.dot((y - field).rowwise().squaredNorm()) / (2 * clamped.sum());
    gamma = std::clamp(double((p.array() > o.threshold).count()) / double(n), 0.05, 0.95);
  }
  const Eigen::ArrayXd squared = (all_y - kernel(all_x, x) * weights).rowwise().squaredNorm();
  variance = std::max(variance, std::pow(o.min_sigma * right_scale, 2));
  const Eigen::ArrayXd e = (-squared / (2 * variance)).exp();
  Eigen::ArrayXd p;
  double g = 0.1;
  for (int step = 0; step <= 5; ++step) {
    p = e / (e + 2 * M_PI * variance * (1 - g) / (g * o.outlier_area));
    g = std::clamp(double((p > 0.5).count()) / double(p.size()), 0.01, 0.95);
  }
  Mask mask;
  for (Eigen::Index i = 0; i < p.size(); ++i) mask.push_back(p[i] > o.threshold ? 1 : 0);
  return mask;
}

TEST_F(Vfc, GuidedFollowsItsDefinition) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SceneOptions scene{300, 0.1 * double(seed), 0.4 * double(seed), seed};
    Correspondences m = (seed % 2 ? stereoScene(scene) : homographyScene(scene)).matches;
    // Some inliers are ambiguous, and no two points are equal.
    for (std::size_t i = 0; i < m.size(); i += 3) m.second_distance[i] = m.distance[i];
    std::vector<std::uint32_t> trusted;
    for (std::uint32_t i = 0; i < m.size(); ++i) {
      if (m.distance[i] < 0.9F * m.second_distance[i]) trusted.push_back(i);
    }
    VfcOptions options;
    options.guided = true;
    const Selection s = VfcSelector(options).select(m);
    EXPECT_EQ(s.mask, guidedByDefinition(m, trusted, options)) << seed;
    EXPECT_GT(s.n_selected, 10u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
  }
}

/// A repeated pattern shifts more matches than are right, but all of these are ambiguous.
TEST_F(Vfc, GuidedFollowsTheTrustedMatches) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Scene scene = homographyScene({1000, 0.3, 1.0, seed});
    Correspondences& m = scene.matches;
    for (std::size_t i = 0; i < 1000; ++i) {
      if (i < 300 && i % 3 != 0) continue;
      m.second_distance[i] = m.distance[i];
      if (i < 300) continue;
      m.right_x[i] = m.left_x[i] + 100;
      m.right_y[i] = m.left_y[i] + 160;
    }
    const Quality q = quality(createSelector("vfc:guided")->select(m).mask, scene.inlier);
    EXPECT_GT(q.precision, 90) << seed;
    EXPECT_GT(q.recall, 95) << seed;
    EXPECT_LT(quality(VfcSelector().select(m).mask, scene.inlier).f, 60) << seed;
  }
}

TEST_F(Vfc, GuidedFitsToAllWhereFewAreTrusted) {
  Correspondences m = homographyScene({400, 0.6, 0.5, 2}).matches;
  const auto plain = createSelector("vfc", {{"lambda", "6"}}), guided = createSelector("vfc:guided");
  const Selection usual = plain->select(m);
  // 9 matches are trusted.
  for (std::size_t i = 9; i < 400; ++i) m.second_distance[i] = m.distance[i];
  EXPECT_EQ(guided->select(m).mask, usual.mask);
  EXPECT_EQ(guided->select(m).score, usual.score);
  // 20 are trusted, all at one left point.
  for (std::size_t i = 0; i < 20; ++i) {
    m.left_x[i] = 300;
    m.left_y[i] = 200;
    m.second_distance[i] = 2 * m.distance[i];
  }
  EXPECT_EQ(guided->select(m).mask, plain->select(m).mask);
}

TEST_F(Vfc, GuidedNeedsRatios) {
  Correspondences m = homographyScene({50, 0.6, 0.5, 2}).matches;
  m.second_distance.clear();
  const Selection s = createSelector("vfc:guided")->select(m);
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_EQ(s.message, "vfc with guided = true needs the column second_distance");
  EXPECT_EQ(VfcSelector().select(m).status, Status::kOk);
}

TEST_F(Vfc, RefusesOptionsOutOfRange) {
  const auto refusal = [](const std::string& name, const std::string& value) {
    return errorOf<std::invalid_argument>([&] { createSelector("vfc", {{name, value}}); });
  };
  EXPECT_TRUE(mentions(refusal("beta", "0"), {"vfc", "beta = 0", "[0.001, 10]"}));
  EXPECT_TRUE(mentions(refusal("lambda", "-3"), {"vfc", "lambda = -3", "[0.001, 1000]"}));
  EXPECT_TRUE(mentions(refusal("threshold", "1.5"), {"vfc", "threshold = 1.5", "[0, 1]"}));
  EXPECT_TRUE(mentions(refusal("inlier_ratio", "1"), {"vfc", "inlier_ratio = 1", "[0.05, 0.95]"}));
  EXPECT_TRUE(mentions(refusal("max_iterations", "0"), {"vfc", "max_iterations = 0", "[1, 10000]"}));
  EXPECT_TRUE(mentions(refusal("control_points", "201"), {"vfc", "control_points = 201", "[0, 200]"}));
  EXPECT_NE(refusal("outlier_area", "nan"), "");
  EXPECT_NE(refusal("kernel_tolerance", "1"), "");
  EXPECT_NE(refusal("energy_change", "1"), "");
}

class VfcOnAdelaideRmf : public ::testing::Test {
 protected:
  void SetUp() override {
    if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
    ASSERT_EQ(adelaidePairs().size(), 36u);
  }
};

TEST_F(VfcOnAdelaideRmf, ReachesThePublishedMeans) {
  const Quality exact = adelaideMeans("vfc"), sparse = adelaideMeans("vfc:sparse");
  EXPECT_NEAR(exact.precision, 97.43, 0.05);
  EXPECT_NEAR(exact.recall, 86.35, 0.05);
  EXPECT_NEAR(exact.f, 90.91, 0.05);
  EXPECT_NEAR(sparse.precision, 97.49, 0.3);
  EXPECT_NEAR(sparse.recall, 86.43, 0.3);
  EXPECT_NEAR(sparse.f, 90.99, 0.3);
}

TEST_F(VfcOnAdelaideRmf, DecidesLikeDenseSolves) {
  constexpr std::size_t kMaxMatches = kSanitized ? 400 : 100000;  // dense solves take minutes there
  std::size_t different = 0, decisions = 0;
  for (const LabelledPair& pair : adelaidePairs()) {
    if (pair.matches.size() > kMaxMatches) continue;
    const Answer expected = byDefinition(pair.matches);
    const Selection s = VfcSelector().select(pair.matches);
    EXPECT_EQ(s.iterations, expected.iterations) << pair.name << " " << pair.matches.size();
    different += differences(s.mask, expected.mask);
    decisions += s.mask.size();
  }
  EXPECT_TRUE(decisions == 11962u || kMaxMatches < 2084) << decisions;
  EXPECT_GT(decisions, 3000u);
  EXPECT_LE(different, 5u);  // none here; the dense solves round too
}

}  // namespace
}  // namespace corrsel::core
