#include <gtest/gtest.h>

#include "corrsel/selectors/lpm.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// The members nearest to match i, equal distances by the matches' coordinates, with at least the first or
/// the match itself taken out.
std::vector<std::uint32_t> neighbourhood(const Correspondences& m, const std::vector<std::uint32_t>& members,
                                         std::uint32_t i, bool left, bool compat) {
  const std::vector<float>&x = left ? m.left_x : m.right_x, &y = left ? m.left_y : m.right_y;
  std::vector<std::pair<std::vector<double>, std::uint32_t>> sorted;
  for (const std::uint32_t j : members) {
    const double dx = double(x[j]) - x[i], dy = double(y[j]) - y[i];
    sorted.push_back({{dx * dx + dy * dy, m.left_x[j], m.left_y[j], m.right_x[j], m.right_y[j]}, j});
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> result;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    if (compat ? k > 0 : sorted[k].second != i) result.push_back(sorted[k].second);
  }
  return result;
}

/// LPM as it is defined, with neighbours by sorting. @pre no two matches are equal
std::pair<Mask, std::vector<double>> byDefinition(const Correspondences& m, const LpmOptions& o) {
  const bool count = o.cost == "count";
  const int longest = count ? o.k : o.k + 2;
  std::vector<std::uint32_t> members(m.size());
  std::iota(members.begin(), members.end(), 0U);
  std::vector<double> cost(m.size());
  for (int pass = 0; pass < 2 && (pass == 0 || int(members.size()) >= longest + 2); ++pass) {
    std::vector<std::uint32_t> accepted;
    for (std::uint32_t i = 0; i < m.size(); ++i) {
      const auto left = neighbourhood(m, members, i, true, o.compat);
      const auto right = neighbourhood(m, members, i, false, o.compat);
      const cv::Point2d vi(double(m.right_x[i]) - m.left_x[i], double(m.right_y[i]) - m.left_y[i]);
      double sum = 0;
      int scales = 0;
      for (const int k : count ? std::vector<int>{o.k} : std::vector<int>{o.k + 2, o.k, o.k - 2}) {
        const int from = count || !o.compat ? 0 : scales;
        ++scales;
        int common = 0, disagreeing = 0;
        for (int a = from; a < from + k; ++a) {
          for (int b = from; b < from + k; ++b) {
            if (left[std::size_t(a)] != right[std::size_t(b)]) continue;
            ++common;
            const std::uint32_t j = left[std::size_t(a)];
            const cv::Point2d vj(double(m.right_x[j]) - m.left_x[j], double(m.right_y[j]) - m.left_y[j]);
            const double ii = vi.dot(vi), jj = vj.dot(vj);
            double agreement = ii == jj ? 1 : 0;
            if (ii > 0 && jj > 0) {
              agreement = vi.dot(vj) / std::sqrt(ii * jj) * std::min(ii, jj) / std::max(ii, jj);
            }
            disagreeing += agreement < o.tau;
          }
        }
        sum += count ? 2 * (k - common) : double(k - common + disagreeing) / k;
      }
      cost[i] = sum / scales;
      if (cost[i] <= (pass == 0 ? o.lambda_first : o.lambda_second) + 1e-9) accepted.push_back(i);
    }
    members = accepted;
  }
  Mask mask(m.size(), 0);
  for (const std::uint32_t i : members) mask[i] = 1;
  return {mask, cost};
}

TEST(Lpm, FollowsTheDefinition) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Correspondences m = homographyScene({150, 0.5, 2.0, seed}).matches;
    // Many-to-one matches: equal distances in one image.
    for (std::size_t i = 5; i < 30; i += 5) {
      m.left_x[i] = m.left_x[0];
      m.left_y[i] = m.left_y[0];
      m.right_x[i + 1] = m.right_x[1];
      m.right_y[i + 1] = m.right_y[1];
    }
    // Some rest.
    for (std::size_t i = 60; i < 70; ++i) {
      m.right_x[i] = m.left_x[i];
      m.right_y[i] = m.left_y[i];
    }
    for (const std::string cost : {"count", "multiscale"}) {
      for (const bool compat : {true, false}) {
        for (const int k : {3, 4, 6}) {
          LpmOptions options;
          options.cost = cost;
          options.compat = compat;
          options.k = k;
          options.lambda_first = cost == "count" ? 2 * k - 2 : 0.8;
          options.lambda_second = cost == "count" ? 2 * k - 4 : 0.5;
          const Selection s = LpmSelector(options).select(m);
          const auto [mask, costs] = byDefinition(m, options);
          EXPECT_EQ(s.mask, mask) << "seed " << seed << " " << cost << " k " << k << " compat " << compat;
          ASSERT_EQ(s.score.size(), m.size());
          for (std::size_t i = 0; i < m.size(); ++i) ASSERT_NEAR(s.score[i], -costs[i], 1e-6);
          EXPECT_EQ(s.iterations, 2);
          EXPECT_EQ(s.status, Status::kOk);
          EXPECT_TRUE(s.n_selected > 0 && s.n_selected < m.size());
        }
      }
    }
  }
}

TEST(Lpm, RestingMatchesAgreeWithEachOther) {
  LpmOptions options;
  options.cost = "multiscale";
  options.k = 4;
  Correspondences m;
  Random random(2);
  for (int i = 0; i < 40; ++i) {
    const cv::Point2f p(float(random.uniform(0, 100)), float(random.uniform(0, 100)));
    m.add(p, p);
  }
  const Selection s = LpmSelector(options).select(m);
  EXPECT_EQ(s.n_selected, 40u);
  for (const float score : s.score) EXPECT_EQ(score, 0.0f);
}

TEST(Lpm, MotionMustAgreeInDirectionAndLength) {
  // Ten matches in a row, all but one moving by (10, 0): that one has all neighbours in common, the motion
  // decides.
  const auto scoreOf = [](const cv::Point2f& motion) {
    Correspondences m;
    for (int i = 0; i < 10; ++i) {
      const cv::Point2f p(float(i) * 100 + float(i * i), 0);
      m.add(p, p + (i == 5 ? motion : cv::Point2f(10, 0)));
    }
    LpmOptions options;
    options.cost = "multiscale";
    options.k = 4;
    options.lambda_first = 0;  // too few survive for a second pass
    options.compat = false;
    return LpmSelector(options).select(m).score[5];
  };
  EXPECT_EQ(scoreOf({10, 0}), 0.0f);
  EXPECT_EQ(scoreOf({-10, 0}), -1.0f);
  EXPECT_EQ(scoreOf({0, 10}), -1.0f);
  EXPECT_EQ(scoreOf({0, 0}), -1.0f);
  // Squared lengths: 20 to 10 is 1/4, still above tau = 0.2; 23 to 10 is 0.19.
  EXPECT_EQ(scoreOf({20, 0}), 0.0f);
  EXPECT_EQ(scoreOf({23, 0}), -1.0f);
}

TEST(Lpm, DuplicatesSupportThemselvesOnlyUnlessMerged) {
  Scene scene = homographyScene({200, 0.6, 0.5, 5});
  const std::size_t n = scene.matches.size();
  std::vector<std::uint32_t> rows(n);
  std::iota(rows.begin(), rows.end(), 0U);
  rows.insert(rows.end(), rows.begin(), rows.begin() + std::ptrdiff_t(n));
  const Correspondences doubled = scene.matches.subset(rows);
  LpmOptions options;
  const Mask once = LpmSelector(options).select(scene.matches).mask;
  const Mask merged = LpmSelector(options).select(doubled).mask;
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(merged[i], once[i]);
    EXPECT_EQ(merged[i + n], once[i]);
  }
  options.merge_duplicates = false;
  EXPECT_EQ(LpmSelector(options).select(doubled).n_selected, 2 * n);
}

TEST(Lpm, NeedsTwoMoreThanItLists) {
  const Scene scene = homographyScene({20, 1.0, 0.0, 6});
  for (const auto& [spec, needed] : {std::pair<const char*, std::size_t>{"lpm", 6}, {"lpm:v2", 10}}) {
    for (const std::size_t n : {needed - 1, needed}) {
      std::vector<std::uint32_t> rows(n);
      std::iota(rows.begin(), rows.end(), 0U);
      // Duplicates do not help.
      rows.push_back(0);
      const Selection s = createSelector(spec)->select(scene.matches.subset(rows));
      EXPECT_EQ(s.status, n < needed ? Status::kTooFew : Status::kOk) << spec << " " << n;
      if (n < needed) {
        EXPECT_EQ(s.message, std::to_string(n) + " distinct matches, lpm needs " + std::to_string(needed));
        EXPECT_EQ(s.n_selected, 0u);
      }
    }
  }
}

TEST(Lpm, LeavesOutTheSecondPassWhereTooFewSurvive) {
  Correspondences m = homographyScene({60, 0.0, 0.5, 7}).matches;
  LpmOptions options;
  options.lambda_first = 0;
  const Selection s = LpmSelector(options).select(m);
  EXPECT_EQ(s.iterations, 1);
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(s.n_selected, 0u);
  // Six are just enough.
  options.lambda_first = 64;
  m = m.subset({0, 1, 2, 3, 4, 5});
  EXPECT_EQ(LpmSelector(options).select(m).iterations, 2);
}

TEST(Lpm, FlagsPointsThatAreAllEqual) {
  for (const bool left : {true, false}) {
    Correspondences m = homographyScene({30, 1.0, 0.0, 8}).matches;
    (left ? m.left_x : m.right_x).assign(30, 5);
    (left ? m.left_y : m.right_y).assign(30, 6);
    const Selection s = LpmSelector().select(m);
    EXPECT_EQ(s.status, Status::kDegenerate);
    EXPECT_EQ(s.n_selected, 0u);
    (left ? m.left_y : m.right_y)[7] = 6.5f;
    EXPECT_EQ(LpmSelector().select(m).status, Status::kOk);
  }
}

TEST(Lpm, MultiscaleNeedsThreeNeighbours) {
  LpmOptions options;
  options.k = 2;
  EXPECT_NO_THROW(LpmSelector{options});
  options.cost = "multiscale";
  EXPECT_EQ(errorOf<std::invalid_argument>([&options] { LpmSelector selector(options); }),
            "option k = 2 is too small for cost = multiscale: at least 3");
  options.k = 3;
  EXPECT_NO_THROW(LpmSelector{options});
  options.k = 32;
  EXPECT_EQ(LpmSelector(options).select(homographyScene().matches).status, Status::kOk);
}

TEST(Lpm, FindsTheRightMatches) {
  const Scene scene = homographyScene({1000, 0.6, 1.0, 9});
  const Quality paper = quality(createSelector("lpm")->select(scene.matches).mask, scene.inlier);
  EXPECT_GT(paper.precision, 85);
  EXPECT_GT(paper.recall, 98);
  const Quality v2 = quality(createSelector("lpm:v2")->select(scene.matches).mask, scene.inlier);
  EXPECT_GT(v2.precision, 95);
  EXPECT_GT(v2.recall, 95);
}

TEST(Lpm, ReachesThePublishedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  ASSERT_EQ(adelaidePairs().size(), 36u);
  const Quality merged = adelaideMeans("lpm:paper");
  EXPECT_NEAR(merged.precision, 82.1, 0.8);
  EXPECT_NEAR(merged.recall, 99.6, 0.8);
  EXPECT_NEAR(merged.f, 89.5, 0.8);
  const Quality unmerged = adelaideMeans("lpm", {{"merge_duplicates", "false"}});
  EXPECT_NEAR(unmerged.precision, 80.9, 0.8);
  EXPECT_NEAR(unmerged.recall, 99.6, 0.8);
  EXPECT_NEAR(unmerged.f, 88.8, 0.8);
  EXPECT_LT(unmerged.precision, merged.precision - 0.5);
  EXPECT_GE(adelaideMeans("lpm:v1").f, 94);
  EXPECT_GE(adelaideMeans("lpm:v2").f, 96);
}

}  // namespace
}  // namespace corrsel::core
