#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <fstream>
#include <map>

#include "base/text.h"
#include "corrsel/selectors/st.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// Affinity of two matches by definition, with a one-to-one rule where the options have it.
double affinityOf(const Correspondences& m, std::size_t i, std::size_t j, const StOptions& o) {
  const double left = std::hypot(double(m.left_x[i]) - m.left_x[j], double(m.left_y[i]) - m.left_y[j]);
  const double right = std::hypot(double(m.right_x[i]) - m.right_x[j], double(m.right_y[i]) - m.right_y[j]);
  if (i == j) return 0;
  if (o.affinity == StOptions::Affinity::kRatio) {
    if (left == 0 && right == 0) return o.duplicate_affinity;
    return std::min(left, right) / std::max(left, right);
  }
  if (o.one_to_one && (left == 0) != (right == 0)) return 0;
  const double d = left - right;
  return std::abs(d) < 3 * o.sigma ? (4.5 - d * d / (2 * o.sigma * o.sigma)) / 4.5 : 0;
}

bool conflict(const Correspondences& m, std::size_t i, std::size_t j, const StOptions& o) {
  const double left = std::hypot(double(m.left_x[i]) - m.left_x[j], double(m.left_y[i]) - m.left_y[j]);
  const double right = std::hypot(double(m.right_x[i]) - m.right_x[j], double(m.right_y[i]) - m.right_y[j]);
  if (o.one_to_one && (left == 0) != (right == 0)) return true;
  if (o.noise_floor > 0 && std::abs(left - right) <= o.noise_floor) return false;
  return affinityOf(m, i, j, o) <= o.threshold;
}

/// Eigenvector by a dense solver in double precision, then the greedy step.
std::pair<Mask, Eigen::VectorXd> byDefinition(const Correspondences& m, const StOptions& o) {
  const auto n = static_cast<Eigen::Index>(m.size());
  Eigen::MatrixXd a(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) a(i, j) = affinityOf(m, std::size_t(i), std::size_t(j), o);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  Eigen::VectorXd v = solver.eigenvectors().col(n - 1);
  v *= (v.sum() < 0 ? -1 : 1) / v.cwiseAbs().maxCoeff();
  Eigen::VectorXd rest = v;
  Mask mask(m.size(), 0);
  for (Eigen::Index best = 0; rest.maxCoeff(&best) > 1e-5;) {
    mask[std::size_t(best)] = 1;
    rest(best) = 0;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (conflict(m, std::size_t(best), std::size_t(j), o)) rest(j) = 0;
    }
  }
  return {mask, v};
}

/// Inliers and outliers, some of which share a point.
Correspondences manyToOne(std::size_t n, std::uint64_t seed) {
  Correspondences m = homographyScene({n, 0.5, 1.0, seed}).matches;
  for (std::size_t i = 0; i + 10 < n; i += 10) {
    m.left_x[i] = m.left_x[i + 1];
    m.left_y[i] = m.left_y[i + 1];
    m.right_x[i + 2] = m.right_x[i + 3];
    m.right_y[i + 2] = m.right_y[i + 3];
  }
  return m.subset(permutation(n, seed));
}

std::vector<std::pair<std::string, StOptions>> variants() {
  std::vector<std::pair<std::string, StOptions>> result(6);
  result[0].first = "paper";
  result[1].first = "threshold 0.7";
  result[1].second.threshold = 0.7;
  result[2].first = "noise floor";
  result[2].second.threshold = 0.8;
  result[2].second.noise_floor = 5;
  result[3] = result[2];
  result[3].first = "noise floor, one to one";
  result[3].second.one_to_one = true;
  result[4].first = "leordeanu_hebert";
  result[4].second.affinity = StOptions::Affinity::kDifference;
  result[4].second.threshold = -1;
  result[4].second.one_to_one = true;
  result[5].first = "difference with conflicts";
  result[5].second.affinity = StOptions::Affinity::kDifference;
  result[5].second.threshold = 0;
  return result;
}

TEST(St, FollowsTheDefinition) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const std::size_t n : {37, 301}) {
      const Correspondences m = manyToOne(n, seed);
      for (const auto& [label, options] : variants()) {
        SCOPED_TRACE(label + ", " + std::to_string(n) + " matches, seed " + std::to_string(seed));
        const auto [mask, v] = byDefinition(m, options);
        const Selection s = StSelector(options).select(m);
        EXPECT_EQ(s.mask, mask);
        EXPECT_EQ(s.status, Status::kOk);
        EXPECT_TRUE(s.n_selected > 0 && s.n_selected < n) << s.n_selected;
        EXPECT_TRUE(s.iterations >= 3 && s.iterations <= 60) << s.iterations;
        for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(s.score[i], v(Eigen::Index(i)), 5e-5);
      }
    }
  }
}

TEST(St, EqualMatchesWeighAsManyAsTheyAre) {
  Correspondences m = manyToOne(120, 4);
  std::vector<std::uint32_t> rows(120);
  std::iota(rows.begin(), rows.end(), 0U);
  for (std::uint32_t i = 0; i < 40; ++i) rows.insert(rows.end(), i % 4, i);
  m = m.subset(rows);
  for (const double affinity : {1.0, 0.5, 0.0}) {
    StOptions options;
    options.duplicate_affinity = affinity;
    const auto [mask, v] = byDefinition(m, options);
    const Selection s = StSelector(options).select(m);
    for (std::size_t i = 0; i < m.size(); ++i) ASSERT_NEAR(s.score[i], v(Eigen::Index(i)), 5e-5);
    // Which of several equal matches is kept where they conflict is free: the first one.
    std::size_t expected = 0;
    for (const std::uint8_t selected : mask) expected += selected;
    EXPECT_EQ(s.n_selected, expected);
    if (affinity > options.threshold) {
      EXPECT_EQ(s.mask, mask);
    }
    for (std::size_t i = 120; i < m.size(); ++i) {
      EXPECT_EQ(s.mask[i], affinity > options.threshold ? s.mask[rows[i]] : 0);
    }
  }
}

TEST(St, AnswersAlikeAtEveryKernelLevelAndWithoutMemory) {
  const LevelGuard guard;
  const Correspondences m = manyToOne(1003, 6);
  for (auto [label, options] : variants()) {
    SCOPED_TRACE(label);
    options.memory_limit = 2048;
    const Selection expected = StSelector(options).select(m);
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      for (const int limit : {0, 1, 2048}) {
        options.memory_limit = limit;
        const Selection s = StSelector(options).select(m);
        EXPECT_EQ(s.mask, expected.mask) << toString(level) << " " << limit;
        EXPECT_EQ(s.score, expected.score) << toString(level) << " " << limit;
        EXPECT_EQ(s.iterations, expected.iterations);
      }
    }
  }
}

TEST(St, AnswersAlikeOnAnyNumberOfThreads) {
  const Correspondences m = manyToOne(2300, 8);
  for (auto [label, options] : variants()) {
    SCOPED_TRACE(label);
    const Selection expected = StSelector(options).select(m);
    EXPECT_GT(expected.n_selected, 0u);
    for (const int threads : {2, 3}) {
      options.threads = threads;
      const Selection s = StSelector(options).select(m);
      EXPECT_EQ(s.mask, expected.mask) << threads;
      EXPECT_EQ(s.score, expected.score) << threads;
      EXPECT_EQ(s.iterations, expected.iterations);
    }
  }
}

TEST(St, StopsAtTheTimeLimit) {
  const Correspondences m = manyToOne(2500, 7);
  StOptions options;
  options.memory_limit = 0;
  const Selection unlimited = StSelector(options).select(m);
  // Longer and longer, until it is long enough for one product, and for all.
  std::vector<Selection> seen;
  for (double seconds = 0.5; seen.empty() || seen.back().status != Status::kOk; seconds += 1) {
    ASSERT_LT(seconds, 1000);
    SCOPED_TRACE(seconds);
    options.max_seconds = seconds;
    const TickingClock clock(1);
    Selection s = StSelector(options).select(m);
    // The clock is not read again after it has shown that the time is over, but for what is reserved.
    EXPECT_LE(clock.looks(), seconds + 3);
    if (s.status == Status::kTooLarge) {
      EXPECT_EQ(s.message, "stopped after 0 products, max_seconds = " + formatNumber(seconds));
      EXPECT_EQ(s.mask, Mask(2500, 0));
      EXPECT_TRUE(s.score.empty());
    } else if (s.status == Status::kTimeLimit) {
      EXPECT_EQ(s.message, "stopped after " + std::to_string(s.iterations) +
                               " products, max_seconds = " + formatNumber(seconds));
      EXPECT_GE(s.iterations, 1);
      EXPECT_LT(s.iterations, unlimited.iterations);
      EXPECT_GT(s.n_selected, 400u);
    }
    if (!seen.empty()) {
      EXPECT_GE(s.iterations, seen.back().iterations);
    }
    seen.push_back(std::move(s));
  }
  EXPECT_EQ(seen.front().status, Status::kTooLarge);
  EXPECT_TRUE(std::any_of(seen.begin(), seen.end(),
                          [](const Selection& s) { return s.status == Status::kTimeLimit; }));
  EXPECT_EQ(seen.back().mask, unlimited.mask);
  EXPECT_EQ(seen.back().score, unlimited.score);
}

TEST(St, DecidesFewAndEqualMatchesByTheRule) {
  Correspondences m;
  EXPECT_EQ(StSelector().select(m).status, Status::kOk);
  m.add({10, 20}, {30, 40});
  const Selection one = StSelector().select(m);
  EXPECT_EQ(one.mask, Mask(1, 0));
  EXPECT_EQ(one.status, Status::kOk);
  EXPECT_EQ(one.message, "no two matches agree");
  EXPECT_EQ(one.score, std::vector<float>(1, 0));
  // Distances 10 and 10 a: kept above the threshold; a = 0.3 is a conflict, of which the first survives.
  for (const auto& [a, selected] :
       {std::pair<float, std::size_t>{0.31f, 2}, {0.3f, 1}, {3.2f, 2}, {3.4f, 1}}) {
    Correspondences two = m;
    two.add({20, 20}, {30, 40 + 10 * a});
    EXPECT_EQ(StSelector().select(two).n_selected, selected) << a;
  }
  // One point shared: affinity 0.
  Correspondences shared = m;
  shared.add({10, 20}, {35, 45});
  EXPECT_EQ(StSelector().select(shared).mask, Mask(2, 0));
  EXPECT_EQ(StSelector().select(shared).message, "no two matches agree");

  m = m.subset(std::vector<std::uint32_t>(40, 0));
  const Selection all = StSelector().select(m);
  EXPECT_EQ(all.mask, Mask(40, 1));
  EXPECT_EQ(all.status, Status::kDegenerate);
  EXPECT_EQ(all.message, "all matches are equal");
  const Selection apart = createSelector("st", {{"duplicate_affinity", "0"}})->select(m);
  EXPECT_EQ(apart.n_selected, 0u);
  EXPECT_EQ(apart.status, Status::kDegenerate);
}

TEST(St, ResolvesTiesByCoordinates) {
  // A square and its image, half of it mirrored: many equal entries.
  Correspondences m;
  for (const float x : {0.0f, 100.0f}) {
    for (const float y : {0.0f, 100.0f}) {
      m.add({x, y}, {x, y});
      m.add({x, y}, {900 - x, y});
    }
  }
  const Selection expected = StSelector().select(m);
  EXPECT_GT(expected.n_selected, 0u);
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const std::vector<std::uint32_t> order = permutation(m.size(), seed);
    EXPECT_EQ(StSelector().select(m.subset(order)).mask, reordered(expected.mask, order));
  }
}

TEST(St, SelectsAsManyAsTheReferencePerPair) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  std::ifstream file(sharedData("adelaidermf") + "/../../reference/adelaide_per_pair.csv");
  if (!file) GTEST_SKIP() << "skipped: the reference counts are not here";
  std::map<std::string, std::vector<std::string>> counts;
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> fields = parseCsvLine(line);
    if (fields.size() == 11 && fields[1] == "ST") counts[fields[0]] = fields;
  }
  ASSERT_EQ(counts.size(), 36u);
  const auto selector = createSelector("st", {{"duplicate_affinity", "0"}});
  for (const LabelledPair& pair : adelaidePairs()) {
    const Mask mask = selector->select(pair.matches).mask;
    std::size_t correct = 0;
    for (const std::uint32_t i : selectedRows(mask)) correct += pair.truth.labels[i] > 0;
    EXPECT_EQ(std::to_string(selectedRows(mask).size()), counts[pair.name][9]) << pair.name;
    EXPECT_EQ(std::to_string(correct), counts[pair.name][10]) << pair.name;
  }
}

TEST(St, ReachesTheExpectedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  ASSERT_EQ(adelaidePairs().size(), 36u);
  const Quality paper = adelaideMeans("st");
  EXPECT_NEAR(paper.precision, 91.5, 0.1);
  EXPECT_NEAR(paper.recall, 87.6, 0.1);
  EXPECT_NEAR(paper.f, 89.1, 0.1);
}

}  // namespace
}  // namespace corrsel::core
