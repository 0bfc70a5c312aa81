#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "adelaide_counts.h"
#include "base/text.h"
#include "corrsel/selectors/adalam.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// Rotation (radians) and scale of the map between the frames of a match.
std::pair<double, double> turnOf(const Correspondences& m, std::size_t i) {
  const AffineFrame &l = m.left_frame[i], &r = m.right_frame[i];
  const cv::Matx22d map = cv::Matx22d(r[0], r[1], r[3], r[4]) * cv::Matx22d(l[0], l[1], l[3], l[4]).inv();
  return {std::atan2(map(1, 0) - map(0, 1), map(0, 0) + map(1, 1)),
          std::sqrt(std::abs(cv::determinant(map)))};
}

/// The largest k so that the k-th smallest error satisfies the rule of AdaLAM.
std::size_t longestPrefix(std::vector<double> squared, std::size_t own, double confidence) {
  std::sort(squared.begin(), squared.end());
  const auto n = double(squared.size());
  std::size_t best = 0;
  for (std::size_t k = 1; k + own <= squared.size(); ++k) {
    if (confidence * n * squared[k + own - 1] <= double(k)) best = k;
  }
  return best;
}

/// AdaLAM as it is defined, with every pair of matches compared. @pre all points are in the images, and all
/// ratios differ
Mask byDefinition(const Correspondences& m, const AdalamOptions& o) {
  const std::size_t n = m.size();
  const auto radius = [&o](const cv::Size& size) { return std::sqrt(size.area() / (o.area_ratio * CV_PI)); };
  const double r1 = radius(m.left_size), rho1 = o.search_expansion * r1,
               rho2 = o.search_expansion * radius(m.right_size);
  const auto left = [&m](std::size_t i) { return cv::Vec2d(m.left_x[i], m.left_y[i]); };
  const auto right = [&m](std::size_t i) { return cv::Vec2d(m.right_x[i], m.right_y[i]); };
  const auto ratio = [&m](std::size_t i) { return m.distance[i] / m.second_distance[i]; };
  const auto place = [](const cv::Vec2d& p) { return std::pair{std::lround(p[0]), std::lround(p[1])}; };
  const double floor = std::pow(o.min_error / rho2, 2);
  Mask mask(n, 0);
  for (std::size_t s = 0; s < n; ++s) {
    bool seed = true;
    for (std::size_t j = 0; j < n; ++j)
      seed = seed && !(ratio(j) < ratio(s) && cv::norm(left(j) - left(s)) < r1);
    if (!seed) continue;
    std::vector<std::size_t> around;
    for (std::size_t j = 0; j < n; ++j) {
      if (j == s || cv::norm(left(j) - left(s)) >= rho1 || cv::norm(right(j) - right(s)) >= rho2) continue;
      if (!m.left_frame.empty()) {
        const auto a = turnOf(m, s), b = turnOf(m, j);
        if (std::cos(a.first - b.first) < std::cos(o.max_rotation * CV_PI / 180)) continue;
        if (std::max(a.second / b.second, b.second / a.second) > o.max_scale_change) continue;
      }
      around.push_back(j);
    }
    if (around.size() < std::size_t(o.min_members)) continue;
    std::vector<std::size_t> votes = around;
    std::sort(votes.begin(), votes.end(), [&](std::size_t a, std::size_t b) { return ratio(a) < ratio(b); });
    for (const bool by_right : {true, false}) {
      if (!o.one_to_one) continue;
      std::map<std::pair<long, long>, bool> taken;
      taken[place(by_right ? right(s) : left(s))] = true;
      std::vector<std::size_t> kept;
      for (const std::size_t j : votes) {
        bool& known = taken[place(by_right ? right(j) : left(j))];
        if (!known) kept.push_back(j);
        known = true;
      }
      votes = kept;
    }
    if (votes.size() < std::size_t(o.min_members)) continue;
    const auto u = [&](std::size_t j) { return (left(j) - left(s)) / rho1; };
    const auto v = [&](std::size_t j) { return (right(j) - right(s)) / rho2; };
    const auto squaredErrors = [&](const cv::Matx22d& a) {
      std::vector<double> squared;
      for (const std::size_t j : votes)
        squared.push_back(std::max(floor, std::pow(cv::norm(a * u(j) - v(j)), 2)));
      return squared;
    };
    std::size_t support = 0;
    cv::Matx22d best;
    for (std::size_t i = 1; i < std::min<std::size_t>(16, votes.size()); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const cv::Vec2d ui = u(votes[i]), uj = u(votes[j]), vi = v(votes[i]), vj = v(votes[j]);
        const cv::Matx22d from(ui[0], uj[0], ui[1], uj[1]);
        if (std::abs(cv::determinant(from)) <= 1e-3 * cv::norm(ui) * cv::norm(uj)) continue;
        const cv::Matx22d a = cv::Matx22d(vi[0], vj[0], vi[1], vj[1]) * from.inv();
        const std::size_t k = longestPrefix(squaredErrors(a), 2, o.confidence);
        if (k > support) {
          support = k;
          best = a;
        }
      }
    }
    if (support == 0) continue;
    cv::Matx22d uu = cv::Matx22d::zeros(), vu = uu;
    for (const std::size_t j : votes) {
      const double squared = std::pow(cv::norm(best * u(j) - v(j)), 2);
      if (o.confidence * double(votes.size()) * squared > double(support)) continue;
      uu += u(j) * u(j).t();
      vu += v(j) * u(j).t();
    }
    best = vu * uu.inv();
    cv::Vec2d values;
    cv::Mat singular;
    cv::SVD::compute(cv::Mat(best), singular, cv::SVD::NO_UV);
    if (singular.at<double>(0) > o.max_stretch || singular.at<double>(1) < 1 / o.max_stretch) continue;
    std::vector<double> squared = squaredErrors(best);
    const std::size_t k = longestPrefix(squared, 0, o.confidence);
    if (k == 0) continue;
    std::sort(squared.begin(), squared.end());
    const double c = double(k) / (double(votes.size()) * squared[k - 1]);
    if (c < o.confidence || double(k) * (1 - 1 / c) < o.min_members) continue;
    mask[s] = 1;
    for (const std::size_t j : around) {
      const double e = std::pow(cv::norm(best * u(j) - v(j)), 2);
      if (o.confidence * double(votes.size()) * e <= double(k)) mask[j] = 1;
    }
  }
  return mask;
}

TEST(Adalam, FollowsTheDefinition) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const SceneOptions options{400 + 50 * seed, 0.1 * double(seed), 0.4 * double(seed % 4), seed};
    Scene scene = seed % 2 ? homographyScene(options) : stereoScene(options);
    Correspondences& m = scene.matches;
    AdalamOptions adalam;
    if (seed % 4 == 1) addFrames(scene);
    if (seed % 3 == 1) {
      for (std::size_t i = 1; i < m.size(); i += 5)
        m.right_x[i] = m.right_x[i - 1], m.right_y[i] = m.right_y[i - 1];
    }
    if (seed > 4) {
      adalam.confidence = 50;
      adalam.area_ratio = 60;
      adalam.one_to_one = false;
      adalam.min_error = 1;
      adalam.max_stretch = 1.2;
      adalam.max_rotation = 10;
    }
    const Selection s = AdalamSelector(adalam).select(m);
    EXPECT_EQ(s.mask, byDefinition(m, adalam)) << seed;
    EXPECT_GT(s.n_selected, 20u) << seed;
    EXPECT_LT(s.n_selected, m.size()) << seed;
  }
}

TEST(Adalam, FindsTheRightMatches) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const bool frames : {true, false}) {
      Scene scene = homographyScene({3000, 0.15, 1.0, seed});
      if (frames) addFrames(scene);
      const Selection s = createSelector("adalam")->select(scene.matches);
      const Quality q = quality(s.mask, scene.inlier);
      EXPECT_GT(q.precision, 97);
      EXPECT_GT(q.recall, 97);
      EXPECT_EQ(s.message, frames ? "" : "no local affine frames: rotations and scales are not compared");
    }
  }
}

/// Three outliers that the detector found eight times each agree with some affine map.
TEST(Adalam, CountsEveryPointOnce) {
  Scene scene;
  scene.matches.left_size = scene.matches.right_size = {640, 480};
  Random random(1);
  const cv::Point2d left[] = {{300, 200}, {360, 210}, {320, 260}},
                    right[] = {{400, 300}, {390, 350}, {440, 330}};
  for (int i = 0; i < 24; ++i) {
    const cv::Point2d shift = uniformPoint(random, 0.4, 0.4);
    addMatch(scene, random, left[i % 3] + shift, right[i % 3] + shift, false);
  }
  EXPECT_EQ(createSelector("adalam")->select(scene.matches).n_selected, 0u);
  EXPECT_EQ(createSelector("adalam", {{"one_to_one", "false"}})->select(scene.matches).n_selected, 24u);
}

TEST(Adalam, SelectsAlmostNothingWhereAllIsWrong) {
  std::size_t selected = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Scene scene;
    scene.matches.left_size = scene.matches.right_size = {640, 480};
    for (int i = 0; i < 2000; ++i) {
      const cv::Point2d left = uniformPoint(random, 640, 480);
      addMatch(scene, random, left, uniformPoint(random, 640, 480), false);
    }
    selected += createSelector("adalam")->select(scene.matches).n_selected;
  }
  EXPECT_LE(selected, 20u * 2000 / 200);
}

TEST(Adalam, SelectsAllOfIdenticalImages) {
  Correspondences m = homographyScene({500, 1.0, 0.0, 4}).matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  const Selection s = createSelector("adalam")->select(m);
  EXPECT_EQ(s.mask, Mask(500, 1));
}

TEST(Adalam, NamesWhatItCannotDecide) {
  const auto select = [](const Correspondences& m) { return createSelector("adalam")->select(m); };
  Correspondences m = homographyScene({5, 1.0, 0.0, 1}).matches;
  EXPECT_EQ(select(m).status, Status::kTooFew);
  EXPECT_EQ(select(m).message, "5 matches, adalam needs 6");
  m = homographyScene({50, 1.0, 0.0, 1}).matches;
  for (const bool left : {true, false}) {
    Correspondences equal = m;
    (left ? equal.left_x : equal.right_x).assign(50, 3.0F);
    (left ? equal.left_y : equal.right_y).assign(50, 4.1F);
    EXPECT_EQ(select(equal).status, Status::kDegenerate);
    EXPECT_EQ(select(equal).message, "all points of an image are equal");
    Correspondences sizeless = m;
    (left ? sizeless.left_size : sizeless.right_size) = {};
    EXPECT_EQ(select(sizeless).status, Status::kUnsupportedInput);
    EXPECT_EQ(select(sizeless).message,
              std::string("adalam needs the size of the ") + (left ? "left" : "right") + " image");
  }
  // Points on a line determine no map.
  Correspondences line = m;
  for (std::size_t i = 0; i < 50; ++i) {
    line.left_y[i] = line.left_x[i] / 2;
    line.right_y[i] = line.right_x[i] = line.left_x[i] / 2;
  }
  EXPECT_EQ(select(line).status, Status::kOk);
  EXPECT_EQ(select(line).n_selected, 0u);
}

TEST(Adalam, NeedsRatiosForSeedsOfAGivenRatio) {
  Correspondences m = homographyScene({500, 0.5, 0.5, 2}).matches;
  EXPECT_EQ(createSelector("adalam:original")->select(m).status, Status::kOk);
  EXPECT_GT(createSelector("adalam:original")->select(m).n_selected, 200u);
  // Without any seed of this ratio nothing is selected.
  Correspondences ambiguous = m;
  ambiguous.second_distance = ambiguous.distance;
  EXPECT_EQ(createSelector("adalam:original")->select(ambiguous).n_selected, 0u);
  EXPECT_GT(createSelector("adalam")->select(ambiguous).n_selected, 200u);
  m.second_distance.clear();
  EXPECT_EQ(createSelector("adalam:original")->select(m).message,
            "adalam with seed_ratio below 1 needs the column second_distance");
  m.distance.clear();
  EXPECT_EQ(createSelector("adalam:original")->select(m).message,
            "adalam with seed_ratio below 1 needs the column distance");
  const Selection s = createSelector("adalam")->select(m);
  EXPECT_EQ(
      s.message,
      "neither descriptor distances nor probabilities: seeds are drawn at random; no local affine frames: "
      "rotations and scales are not compared");
  EXPECT_GT(s.n_selected, 200u);
  EXPECT_EQ(createSelector("adalam", {{"seed", "0"}})->select(m).score, s.score);
  EXPECT_NE(createSelector("adalam", {{"seed", "1"}})->select(m).score, s.score);
}

TEST(Adalam, FramesKeepStrangersOut) {
  Scene scene = homographyScene({1000, 0.5, 1.0, 5});
  addFrames(scene, 0.01);
  const auto rotation = [](double degrees) {
    const double c = std::cos(degrees * CV_PI / 180), s = std::sin(degrees * CV_PI / 180);
    return cv::Matx22d(c, -s, s, c);
  };
  Correspondences& m = scene.matches;
  // Frames of inliers, which are no seeds: two are turned, two are scaled, one is singular.
  const std::vector<cv::Matx22d> changes = {rotation(-40),     rotation(40),      rotation(25),
                                            1.7 * rotation(0), 0.6 * rotation(0), 1.4 * rotation(0),
                                            0 * rotation(0)};
  const bool kept[] = {false, false, true, false, false, true, false};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    AffineFrame& f = m.right_frame[i];
    const cv::Matx22d frame = changes[i] * cv::Matx22d(f[0], f[1], f[3], f[4]);
    f = {float(frame(0, 0)), float(frame(0, 1)), f[2], float(frame(1, 0)), float(frame(1, 1)), f[5]};
    m.second_distance[i] = m.distance[i];
  }
  const Mask with = createSelector("adalam")->select(m).mask;
  for (std::size_t i = 0; i < changes.size(); ++i) EXPECT_EQ(with[i] != 0, kept[i]) << i;
  const Selection without =
      createSelector("adalam", {{"max_rotation", "180"}, {"max_scale_change", "10"}})->select(m);
  for (std::size_t i = 0; i < changes.size(); ++i) EXPECT_EQ(without.mask[i], 1) << i;
  EXPECT_EQ(without.message, "");
}

TEST(Adalam, StopsAtTheTimeLimit) {
  const Correspondences m = homographyScene({2000, 0.5, 0.5, 3}).matches;
  const Selection all = createSelector("adalam")->select(m);
  std::size_t before = 0;
  for (const double limit : {0.5, 20.5, 60.5}) {
    const TickingClock clock(1);
    const Selection s = createSelector("adalam", {{"max_seconds", formatNumber(limit)}})->select(m);
    EXPECT_EQ(s.status, limit < 1 ? Status::kTooLarge : Status::kTimeLimit);
    EXPECT_EQ(s.message, "stopped after " + std::to_string(s.iterations) +
                             " seeds, max_seconds = " + formatNumber(limit));
    EXPECT_LT(s.iterations, all.iterations);
    EXPECT_TRUE(limit < 1 ? s.n_selected == 0 : s.n_selected > before);
    before = s.n_selected;
    for (std::size_t i = 0; i < m.size(); ++i) EXPECT_LE(s.mask[i], all.mask[i]);
  }
}

TEST(Adalam, ReachesTheExpectedMeansOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  ASSERT_EQ(adelaidePairs().size(), 36u);
  const Quality q = adelaideMeans("adalam");
  EXPECT_NEAR(q.precision, 98.9, 0.4);
  EXPECT_NEAR(q.recall, 97.6, 0.5);
  EXPECT_NEAR(q.f, 98.2, 0.4);
  // The counts of the prototype in Python.
  expectCounts("adalam",
               {{"barrsmith", {76, 74}},
                {"biscuit", {143, 143}},
                {"cubechips", {142, 141}},
                {"hartley", {124, 123}},
                {"unionhouse", {74, 73}}},
               4);
}

}  // namespace
}  // namespace corrsel::core
