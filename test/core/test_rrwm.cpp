#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "corrsel/reference/rrwm.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// Reweighted random walks as they are defined, on the dense matrix of the ratios of distances.
std::vector<double> reweightedByDefinition(const Correspondences& m) {
  const std::size_t n = m.size();
  std::vector<std::vector<double>> a(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const double d = std::hypot(double(m.left_x[i]) - m.left_x[j], double(m.left_y[i]) - m.left_y[j]);
      const double e = std::hypot(double(m.right_x[i]) - m.right_x[j], double(m.right_y[i]) - m.right_y[j]);
      if (d > 0 && e > 0) a[i][j] = std::min(d / e, e / d);
    }
  }
  const auto normalise = [n](std::vector<double>& v, const std::vector<float>& x,
                             const std::vector<float>& y) {
    std::vector<double> sums(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) sums[i] += x[i] == x[j] && y[i] == y[j] ? v[j] : 0;
    }
    for (std::size_t i = 0; i < n; ++i) v[i] /= sums[i];
  };
  std::vector<double> q(n, 1 / double(n)), jump = q;
  for (int step = 0; step < 60; ++step) {
    std::vector<double> next(n, 0);
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) next[i] += a[i][j] * (0.2 * q[j] + 0.8 * jump[j]);
      sum += next[i];
    }
    for (double& value : next) value /= sum;
    q = next;
    const double largest = *std::max_element(q.begin(), q.end());
    for (std::size_t i = 0; i < n; ++i) jump[i] = std::exp(30 * q[i] / largest);
    for (int k = 0; k < 300; ++k) {
      normalise(jump, m.left_x, m.left_y);
      normalise(jump, m.right_x, m.right_y);
    }
    const double total = std::accumulate(jump.begin(), jump.end(), 0.0);
    for (double& value : jump) value /= total;
  }
  const double largest = *std::max_element(q.begin(), q.end());
  for (double& value : q) value /= largest;
  return q;
}

TEST(Rrwm, FollowsItsDefinition) {
  // Several matches of one left or right point, whose jumps compete with each other.
  Correspondences m = homographyScene({60, 0.6, 1.0, 3}).matches;
  for (std::size_t i = 0; i < 12; ++i) {
    m.left_x[40 + i] = m.left_x[i];
    m.left_y[40 + i] = m.left_y[i];
  }
  for (std::size_t i = 0; i < 8; ++i) {
    m.right_x[52 + i] = m.right_x[20 + i];
    m.right_y[52 + i] = m.right_y[20 + i];
  }
  // And equal matches.
  std::vector<std::uint32_t> rows = permutation(60, 1);
  rows.insert(rows.end(), {5, 5, 50});
  m = m.subset(rows);
  const Selection s = createSelector("rrwm")->select(m);
  const std::vector<double> q = reweightedByDefinition(m);
  for (std::size_t i = 0; i < m.size(); ++i) EXPECT_NEAR(s.score[i], q[i], 1e-3) << i;
  // The order of the input does not matter.
  const std::vector<std::uint32_t> order = permutation(m.size(), 2);
  const Selection other = createSelector("rrwm")->select(m.subset(order));
  EXPECT_EQ(other.mask, reordered(s.mask, order));
  EXPECT_EQ(other.score, reordered(s.score, order));
}

TEST(Rrwm, FindsTheInliers) {
  const Scene scene = homographyScene({2000, 0.6, 0.5, 1});
  const Quality q = quality(createSelector("rrwm")->select(scene.matches).mask, scene.inlier);
  EXPECT_GE(q.precision, 80);
  EXPECT_GE(q.recall, 95);
}

TEST(Rrwm, DecidesFewAndEqualMatches) {
  const auto selector = createSelector("rrwm");
  Correspondences m = homographyScene({40, 1.0, 0.0, 2}).matches;
  EXPECT_EQ(selector->select({}).status, Status::kOk);
  EXPECT_EQ(selector->select(m.subset({0})).n_selected, 0u);
  EXPECT_EQ(selector->select(m.subset({0, 1})).n_selected, 2u);
  // Equal matches share their points.
  const Selection equal = selector->select(m.subset({0, 0, 0}));
  EXPECT_EQ(equal.status, Status::kDegenerate);
  EXPECT_EQ(equal.n_selected, 0u);
  // Identical images.
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  EXPECT_EQ(selector->select(m).n_selected, 40u);
  // Two matches whose distances differ by a factor of five.
  Correspondences zoomed;
  zoomed.add({0, 0}, {0, 0});
  zoomed.add({10, 0}, {50, 0});
  EXPECT_EQ(selector->select(zoomed).n_selected, 0u);
  EXPECT_EQ(createSelector("rrwm", {{"threshold", "0.1"}})->select(zoomed).n_selected, 2u);
}

TEST(Rrwm, StopsAtTheTimeLimit) {
  const Correspondences m = homographyScene({1500, 0.6, 1.0, 7}).matches;
  std::vector<Status> seen;
  for (double seconds = 0.5; seen.empty() || seen.back() != Status::kOk; seconds += 1) {
    ASSERT_LT(seconds, 2000);
    const TickingClock clock(1);
    const Selection s = createSelector("rrwm", {{"max_seconds", formatNumber(seconds)}})->select(m);
    EXPECT_LE(clock.looks(), seconds + 3);
    if (s.status == Status::kTooLarge) {
      EXPECT_EQ(s.n_selected, 0u);
    }
    seen.push_back(s.status);
  }
  EXPECT_EQ(seen.front(), Status::kTooLarge);
  EXPECT_GT(std::count(seen.begin(), seen.end(), Status::kTimeLimit), 0);
}

TEST(Rrwm, SelectsAsTheReferenceOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const std::map<std::string, std::pair<std::size_t, std::size_t>> golden = {{"barrsmith", {120, 74}},
                                                                             {"biscuit", {164, 146}},
                                                                             {"cubechips", {187, 137}},
                                                                             {"hartley", {145, 123}},
                                                                             {"unionhouse", {122, 78}}};
  std::size_t found = 0;
  for (const LabelledPair& pair : adelaidePairs()) {
    const auto expected = golden.find(pair.name);
    if (expected == golden.end()) continue;
    ++found;
    const Mask mask = createSelector("rrwm")->select(pair.matches).mask;
    std::size_t correct = 0;
    for (const std::uint32_t i : selectedRows(mask)) correct += pair.truth.labels[i] > 0;
    EXPECT_EQ(selectedRows(mask).size(), expected->second.first) << pair.name;
    EXPECT_EQ(correct, expected->second.second) << pair.name;
  }
  EXPECT_EQ(found, golden.size());
  EXPECT_NEAR(adelaideMeans("rrwm").f, 87.4, 0.3);
}

}  // namespace
}  // namespace corrsel::core
