#include <gtest/gtest.h>

#include <cmath>

#include "corrsel/reference/gaim.h"
#include "geometry/frame_map.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Gaim, FindsAPlaneAmongOutliers) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Scene scene = homographyScene({1500, 0.3, 1.0, seed});
    addFrames(scene, 0.05, seed);
    EXPECT_GE(quality(GaimSelector().select(scene.matches).mask, scene.inlier).f, 95);
  }
}

/// The pairs of neighbours of a scene and their agreement, written out.
std::vector<std::vector<double>> agreements(const Correspondences& m, std::size_t k, double max_error) {
  const std::size_t n = m.size();
  std::vector<cv::Matx22d> maps;
  for (std::size_t i = 0; i < n; ++i) {
    const auto map = frameMap(m.left_frame[i], m.right_frame[i]).value();
    maps.emplace_back(map[0], map[1], map[2], map[3]);
  }
  const auto left = [&](std::size_t i) { return cv::Vec2d(m.left_x[i], m.left_y[i]); };
  const auto right = [&](std::size_t i) { return cv::Vec2d(m.right_x[i], m.right_y[i]); };
  std::vector<std::vector<double>> result(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t j = 0; j < n; ++j) {
      if (j != i) near.push_back({cv::norm(left(j) - left(i)), j});
    }
    std::sort(near.begin(), near.end());
    for (std::size_t e = 0; e < k; ++e) {
      const std::size_t j = near[e].second;
      if (cv::norm(left(j) - left(i)) <= 1 || cv::norm(right(j) - right(i)) <= 1) continue;
      double sum = 0;
      for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)}) {
        sum += cv::norm(right(a) + maps[a] * (left(b) - left(a)) - right(b));
        sum += cv::norm(left(a) + maps[a].inv() * (right(b) - right(a)) - left(b));
      }
      result[i][j] = std::max(0.0, 1 - sum / 4 / max_error);
    }
  }
  return result;
}

/// The energy of the header.
double energy(const std::vector<std::vector<double>>& agreement, const std::vector<double>& ratio,
              const std::vector<std::uint8_t>& kept, double theta, double lambda, double k) {
  double own = 0, pairs = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i] == 0) continue;
    own += theta - (1 - ratio[i]) / 2;
    for (std::size_t j = 0; j < kept.size(); ++j) pairs += kept[j] * agreement[i][j];
  }
  return own - lambda / (2 * k) * pairs;
}

TEST(Gaim, IsIteratedConditionalModesOfTheEnergy) {
  for (const double theta : {0.5, 1.5, 3.0, 5.0}) {
    Scene scene = homographyScene({120, 0.5, 1.0, 4});
    addFrames(scene);
    const std::size_t n = 120, k = 15;
    const double lambda = 8, max_error = 30;
    std::vector<double> ratio;
    for (std::size_t i = 0; i < n; ++i)
      ratio.push_back(std::min(1.0, double{scene.matches.distance[i]} / scene.matches.second_distance[i]));
    const auto agreement = agreements(scene.matches, k, max_error);
    std::vector<std::uint8_t> kept(n, 1);
    double now = energy(agreement, ratio, kept, theta, lambda, k);
    // From the last match to the first one, since the order must not matter.
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = n; i-- > 0;) {
        kept[i] ^= 1;
        const double other = energy(agreement, ratio, kept, theta, lambda, k);
        if (other < now) {
          now = other;
          changed = true;
        } else {
          kept[i] ^= 1;
        }
      }
    }
    const Selection s =
        createSelector("gaim",
                       {{"k", "15"}, {"theta", std::to_string(theta)}, {"lambda", "8"}, {"max_error", "30"}})
            ->select(scene.matches);
    EXPECT_EQ(s.mask, kept) << theta;
    EXPECT_EQ(s.iterations, n - s.n_selected + 1);
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<std::uint8_t> with = kept, without = kept;
      with[i] = 1;
      without[i] = 0;
      const double saved = theta - energy(agreement, ratio, with, theta, lambda, k) +
                           energy(agreement, ratio, without, theta, lambda, k);
      ASSERT_NEAR(s.score[i], saved, 1e-3 * (1 + std::abs(saved))) << theta << " " << i;
    }
  }
}

TEST(Gaim, KeepsDistinctiveMatches) {
  Scene scene = homographyScene({100, 1.0, 0.0, 5});
  addFrames(scene);
  for (std::size_t i = 0; i < 100; ++i) {
    scene.matches.distance[i] = float(i);
    scene.matches.second_distance[i] = 100;
  }
  // Without rewards for neighbours, ratios below 0.4 decide.
  const OptionMap options = {{"lambda", "0"}, {"theta", "0.3"}};
  const Selection s = createSelector("gaim", options)->select(scene.matches);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(s.mask[i], i < 40 ? 1 : 0) << i;
  // A match without a ratio earns nothing.
  scene.matches.second_distance[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(createSelector("gaim", options)->select(scene.matches).mask[3], 0);
  scene.matches.distance.clear();
  EXPECT_EQ(createSelector("gaim", options)->select(scene.matches).n_selected, 0u);
}

TEST(Gaim, OneToOneKeepsTheBestOfAPoint) {
  Scene scene = homographyScene({300, 1.0, 0.5, 6});
  addFrames(scene);
  // Match 1 goes to the point of match 0, and match 3 leaves from the point of match 2, both a little off.
  Correspondences& m = scene.matches;
  const auto copy = [&m](std::size_t from, std::size_t to) {
    m.left_x[to] = m.left_x[from];
    m.left_y[to] = m.left_y[from];
    m.right_x[to] = m.right_x[from];
    m.right_y[to] = m.right_y[from];
    m.left_frame[to] = m.left_frame[from];
    m.right_frame[to] = m.right_frame[from];
  };
  copy(0, 1);
  m.left_x[1] += 4;
  copy(2, 3);
  m.right_y[3] += 4;
  EXPECT_EQ(GaimSelector().select(m).n_selected, 300u);
  const Selection s = createSelector("gaim", {{"one_to_one", "true"}})->select(m);
  EXPECT_EQ(s.mask[0], 1);
  EXPECT_EQ(s.mask[1], 0);
  EXPECT_EQ(s.mask[2], 1);
  EXPECT_EQ(s.mask[3], 0);
  EXPECT_GE(s.n_selected, 290u);
}

TEST(Gaim, RandomMatchesAreDropped) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Scene scene = homographyScene({2000, 0.0, 1.0, seed});
    addFrames(scene, 0.05, seed);
    const Selection s = GaimSelector().select(scene.matches);
    EXPECT_LE(s.n_selected, 10u);
    EXPECT_EQ(s.status, Status::kOk);
  }
}

TEST(Gaim, DecidesDegenerateInput) {
  Scene scene = homographyScene({60, 1.0, 0.0, 8});
  const GaimSelector gaim;
  Selection s = gaim.select(scene.matches);
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_EQ(s.message, "gaim needs the local affine frames of the left features");
  addFrames(scene);
  EXPECT_EQ(gaim.select({}).status, Status::kOk);
  s = gaim.select(scene.matches.subset({0}));
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(s.n_selected, 0u);
  EXPECT_EQ(s.message, "no match is supported by its neighbours");
  Correspondences equal = scene.matches;
  equal.left_x.assign(60, 5);
  equal.left_y.assign(60, 6);
  s = gaim.select(equal);
  EXPECT_EQ(s.status, Status::kDegenerate);
  EXPECT_EQ(s.message, "all points of an image are equal");
  Correspondences flat = scene.matches;
  flat.right_frame.assign(60, {0, 0, 0, 0, 0, 0});
  s = gaim.select(flat);
  EXPECT_EQ(s.status, Status::kDegenerate);
  EXPECT_EQ(s.message, "no match has usable frames");
  flat = scene.matches;
  flat.right_frame[7] = {0, 0, 0, 0, 0, 0};
  s = gaim.select(flat);
  EXPECT_EQ(s.message, "1 matches have no usable frames");
  EXPECT_TRUE(std::isnan(s.score[7]));
  EXPECT_EQ(s.mask[7], 0);
  EXPECT_GE(s.n_selected, 50u);
  Correspondences same = scene.matches;
  same.right_x = same.left_x;
  same.right_y = same.left_y;
  same.right_frame = same.left_frame;
  EXPECT_EQ(gaim.select(same).n_selected, 60u);
}

}  // namespace
}  // namespace corrsel::core
