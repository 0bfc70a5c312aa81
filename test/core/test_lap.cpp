#include <gtest/gtest.h>

#include <limits>

#include "adelaide_counts.h"
#include "corrsel/reference/lap.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

double cross(const cv::Point2d& a, const cv::Point2d& b) { return std::abs(a.x * b.y - a.y * b.x); }

/// The cost of match i from its nearest matches in the left or in the right image.
double costByDefinition(const Correspondences& m, std::size_t i, bool by_left, const LapOptions& o) {
  const auto left = [&](std::size_t j) { return cv::Point2d(m.left_x[j], m.left_y[j]); };
  const auto right = [&](std::size_t j) { return cv::Point2d(m.right_x[j], m.right_y[j]); };
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t j = 0; j < m.size(); ++j) {
    if (j != i) near.emplace_back(by_left ? cv::norm(left(j) - left(i)) : cv::norm(right(j) - right(i)), j);
  }
  std::sort(near.begin(), near.end());
  near.resize(std::size_t(o.candidates));
  const cv::Point2d own = right(i) - left(i);
  for (auto& [key, j] : near) {
    const cv::Point2d other = right(j) - left(j);
    const double a = own.dot(own), b = other.dot(other);
    const double difference = cv::norm(own - other);
    key = difference <= o.noise_floor ? -1.5
          : std::min(a, b) <= o.noise_floor * o.noise_floor
              ? -o.noise_floor / difference
              : -(own.dot(other) / std::sqrt(a * b) / 2 + std::min(a, b) / std::max(a, b));
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> deviations;
  for (int a = 0; a < o.k; ++a) {
    for (int b = a + 1; b < o.k; ++b) {
      for (int c = b + 1; c < o.k; ++c) {
        double ratios[2][3];
        for (const bool in_left : {true, false}) {
          const auto relative = [&](int s) {
            const std::size_t j = near[std::size_t(s)].second;
            return in_left ? left(j) - left(i) : right(j) - right(i);
          };
          const double s1 = cross(relative(a), relative(b)), s2 = cross(relative(b), relative(c)),
                       s3 = cross(relative(a), relative(c));
          ratios[in_left][0] = s1 / s2;
          ratios[in_left][1] = s1 / s3;
          ratios[in_left][2] = s2 / s3;
        }
        double sum = 0;
        for (int r = 0; r < 3; ++r) sum += 1 - std::exp(-std::abs(ratios[0][r] - ratios[1][r]));
        deviations.push_back(sum);
      }
    }
  }
  std::sort(deviations.begin(), deviations.end());
  deviations.resize(std::size_t(std::lround(o.triples_share * double(deviations.size()))));
  return mean(deviations);
}

TEST(Lap, FollowsTheDefinition) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const SceneOptions options{100 + 100 * seed, 0.4 + 0.12 * double(seed), 0.3 * double(seed), seed};
    const Correspondences m = (seed % 2 ? homographyScene(options) : stereoScene(options)).matches;
    LapOptions lap;
    if (seed > 2) {
      lap.candidates = 15;
      lap.k = 7;
      lap.triples_share = 0.3;
      lap.noise_floor = 0;
    }
    const Selection s = LapSelector(lap).select(m);
    for (std::size_t i = 0; i < m.size(); ++i) {
      const double cost = (costByDefinition(m, i, true, lap) + costByDefinition(m, i, false, lap)) / 2;
      ASSERT_NEAR(s.score[i], -cost, 2e-3) << seed << " " << i;
      if (std::abs(cost - lap.lambda) > 2e-3) {
        EXPECT_EQ(s.mask[i] != 0, cost < lap.lambda);
      }
    }
    EXPECT_GT(s.n_selected, 10u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
  }
}

TEST(Lap, FindsTheRightMatches) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene = homographyScene({1000, 0.7, 0.5, seed});
    const Quality q = quality(createSelector("lap")->select(scene.matches).mask, scene.inlier);
    EXPECT_GT(q.precision, 97);
    EXPECT_GT(q.recall, 85);
  }
}

TEST(Lap, NamesWhatItCannotDecide) {
  const auto selector = createSelector("lap");
  EXPECT_EQ(selector->select(homographyScene({25, 1.0, 0.0, 1}).matches).message,
            "25 distinct matches, lap needs 26");
  Correspondences m = homographyScene({50, 1.0, 0.0, 1}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  EXPECT_EQ(selector->select(m).mask, Mask(50, 1));
  // Points on a line form triangles without an area.
  for (std::size_t i = 0; i < 50; ++i) m.left_y[i] = m.right_y[i] = 100;
  EXPECT_EQ(selector->select(m).n_selected, 0u);
  m.left_x.assign(50, 1);
  EXPECT_EQ(selector->select(m).status, Status::kDegenerate);
  EXPECT_TRUE(mentions(errorOf([] {
                         createSelector("lap", {{"candidates", "9"}});
                       }),
                       {"lap", "k = 10", "candidates = 9"}));
}

TEST(Lap, ReachesTheExpectedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("lap", {{"noise_floor", "0"}, {"lambda", "0.7"}});
  EXPECT_NEAR(q.f, 97.7, 0.3);
  EXPECT_GT(adelaideMeans("lap").f, 97.3);
}

}  // namespace
}  // namespace corrsel::core
