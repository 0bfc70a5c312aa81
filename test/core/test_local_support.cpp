#include <gtest/gtest.h>

#include <complex>
#include <limits>

#include "search/local_support.h"
#include "search/ordering.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::vector<std::uint32_t> byQuality(const Correspondences& matches) {
  Ordering ordering;
  std::vector<std::uint32_t> rows, positions;
  ordering.shuffle(matches, 0, rows);
  if (ordering.byQuality(matches, rows, positions)) {
    for (std::uint32_t& position : positions) position = rows[position];
    return positions;
  }
  return rows;
}

LocalSupport supportOf(const Correspondences& matches, int threads = 1) {
  LocalSupport support;
  support.compute(matches, byQuality(matches), threads);
  return support;
}

/// Share of the matches of one kind that a mask selects.
double share(const std::vector<std::uint8_t>& mask, const std::vector<std::uint8_t>& inlier,
             std::uint8_t kind) {
  double selected = 0, all = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    all += inlier[i] == kind ? 1 : 0;
    selected += inlier[i] == kind && mask[i] ? 1 : 0;
  }
  return selected / all;
}

/// Matches of two affine motions, one in each half of the left image, and outliers. `motion` receives 0 or
/// 1 for inliers and 2 for outliers.
Scene twoMotions(std::size_t n, std::uint64_t seed, std::vector<int>& motion) {
  Random random(seed);
  Scene scene;
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    const int kind = i % 2 == 0 ? 2 : left.x < kSceneWidth / 2.0 ? 0 : 1;
    cv::Point2d right = uniformPoint(random, kSceneWidth, kSceneHeight);
    if (kind == 0) right = {1.1 * left.x + 0.2 * left.y + 20, -0.2 * left.x + 1.1 * left.y + 30};
    if (kind == 1) right = {0.8 * left.x - 0.1 * left.y + 40, 0.1 * left.x + 0.8 * left.y + 10};
    if (kind != 2) right += 0.5 * normalPoint(random);
    addMatch(scene, random, left, right, kind != 2);
    motion.push_back(kind);
  }
  return scene;
}

/// S of a hypothesis by the formulas of the class, in double precision. The visible share of a disc is
/// counted on a grid of points.
double supportBySums(const Correspondences& m, std::size_t i, const LinearMap& map, int partner) {
  const auto [left_most, right_most] = std::minmax_element(m.right_x.begin(), m.right_x.end());
  const auto [top_most, bottom_most] = std::minmax_element(m.right_y.begin(), m.right_y.end());
  const double left_edge = std::max(0.0, *left_most - 3.0), top_edge = std::max(0.0, *top_most - 3.0);
  const double right_edge = std::min<double>(m.right_size.width, *right_most + 3.0);
  const double bottom_edge = std::min<double>(m.right_size.height, *bottom_most + 3.0);
  const double diagonal = std::hypot(m.right_size.width, m.right_size.height);
  std::vector<double> weight(m.size());
  for (std::size_t j = 0; j < m.size(); ++j) {
    double same = 0;
    for (std::size_t o = 0; o < m.size(); ++o) {
      same += std::round(m.right_x[o]) == std::round(m.right_x[j]) &&
                      std::round(m.right_y[o]) == std::round(m.right_y[j])
                  ? 1
                  : 0;
    }
    weight[j] = 1 / same;
  }
  const double all = std::accumulate(weight.begin(), weight.end(), 0.0);
  const double significant = std::log(6.0 * double(m.size())) + 4;
  double best = 0, in_disc = 0;
  for (int part = 16; part >= 2; part /= 2) {
    if (part < 8 && (best > 2 * significant || (best < 2 && in_disc >= 40))) break;
    const double radius = diagonal / part;
    double seen = 0, tried = 0;
    for (int row = -40; row <= 40; ++row) {
      for (int column = -40; column <= 40; ++column) {
        if (row * row + column * column > 1600) continue;
        const double x = m.right_x[i] + radius * column / 40, y = m.right_y[i] + radius * row / 40;
        ++tried;
        seen += x >= left_edge && x <= right_edge && y >= top_edge && y <= bottom_edge ? 1 : 0;
      }
    }
    for (const double rho : {0.12, 0.3}) {
      if (rho > 0.2 && part < 8) continue;
      double k = 0, left = 0, right = 0;
      for (std::size_t j = 0; j < m.size(); ++j) {
        const double dx = double(m.left_x[j]) - m.left_x[i], dy = double(m.left_y[j]) - m.left_y[i];
        const double vx = double(m.right_x[j]) - m.right_x[i], vy = double(m.right_y[j]) - m.right_y[i];
        const double ux = map[0] * dx + map[1] * dy, uy = map[2] * dx + map[3] * dy;
        const double u = std::hypot(ux, uy), v = std::hypot(vx, vy);
        if (v <= 3) continue;
        if (v <= radius) right += weight[j];
        if (u <= 3 || u > radius) continue;
        left += weight[j];
        if (std::hypot(vx - ux, vy - uy) <= std::max(3.0, rho * u) && int(j) != partner) k += weight[j];
      }
      in_disc = left;
      const double share = std::max(rho * rho / 2, 9 / (radius * radius));
      const double lambda = left * right / all * share / (seen / tried) + 0.02;
      if (k > lambda) best = std::max(best, k * std::log(k / lambda) - (k - lambda));
    }
  }
  return partner >= 0 ? best - 1 : best;
}

TEST(LocalSupport, FindsTheMatchesOfAPlaneWithAndWithoutFrames) {
  for (const double inlier_ratio : {0.9, 0.5, 0.1}) {
    Scene scene = homographyScene({1000, inlier_ratio, 1.0, 3});
    for (const bool frames : {false, true}) {
      SCOPED_TRACE(std::to_string(inlier_ratio) + (frames ? " with frames" : " without frames"));
      if (frames) addFrames(scene);
      const LocalSupport support = supportOf(scene.matches);
      ASSERT_GE(support.survivors().size(), 50u);
      std::size_t right = 0;
      for (const std::uint32_t row : support.survivors()) right += scene.inlier[row];
      EXPECT_GE(double(right), 0.9 * double(support.survivors().size()));
      EXPECT_GE(share(support.local(), scene.inlier, 1), 0.9);
      EXPECT_LE(share(support.local(), scene.inlier, 0), 0.03);
      EXPECT_EQ(support.localSize(), selectedRows(support.local()).size());
      for (std::size_t i = 0; i < scene.matches.size(); ++i)
        EXPECT_GE(support.extended()[i], support.local()[i]);
    }
  }
}

TEST(LocalSupport, IsWhatTheFormulasGive) {
  Scene scene = homographyScene({150, 0.4, 1.0, 4});
  // Several matches with one right point.
  for (std::size_t i = 0; i < 30; i += 3) {
    scene.matches.right_x[i + 1] = scene.matches.right_x[i] + 0.1F;
    scene.matches.right_y[i + 1] = scene.matches.right_y[i];
  }
  addFrames(scene);
  const Correspondences& m = scene.matches;
  const LocalSupport support = supportOf(m);
  std::size_t by_frame = 0;
  for (std::size_t i = 0; i < m.size(); ++i) {
    const AffineFrame &f = m.left_frame[i], &g = m.right_frame[i];
    const cv::Matx22d map = cv::Matx22d(g[0], g[1], g[3], g[4]) * cv::Matx22d(f[0], f[1], f[3], f[4]).inv();
    const double of_frame =
        supportBySums(m, i, {float(map.val[0]), float(map.val[1]), float(map.val[2]), float(map.val[3])}, -1);
    // The nearest match that may serve as a partner.
    int partner = -1;
    double nearest = 1e9;
    LinearMap similarity{};
    for (std::size_t j = 0; j < m.size(); ++j) {
      const std::complex<double> left(m.left_x[j] - m.left_x[i], m.left_y[j] - m.left_y[i]);
      const std::complex<double> right(m.right_x[j] - m.right_x[i], m.right_y[j] - m.right_y[i]);
      if (std::abs(left) < 8 || std::abs(right) < 3 || std::abs(left) >= nearest) continue;
      const std::complex<double> ratio = right / left;
      if (std::abs(ratio) > 6 || std::abs(ratio) < 1.0 / 6) continue;
      nearest = std::abs(left);
      partner = int(j);
      similarity = {float(ratio.real()), float(-ratio.imag()), float(ratio.imag()), float(ratio.real())};
    }
    const bool sure = of_frame > 2 * (std::log(6.0 * 150) + 4);
    const double of_pair = partner >= 0 && !sure ? supportBySums(m, i, similarity, partner) : 0;
    // The grid gives the visible share of a disc within 3 %.
    const double expected = std::max({of_frame, of_pair, 0.0});
    EXPECT_NEAR(support.support()[i], expected, 0.1 + 0.03 * expected) << i;
    by_frame += of_frame > of_pair ? 1 : 0;
  }
  EXPECT_GT(by_frame, 20u);
  EXPECT_LT(by_frame, 149u);
  std::size_t significant = 0;
  for (const float of_match : support.support()) significant += of_match > std::log(6.0 * 150) + 4 ? 1 : 0;
  EXPECT_EQ(support.survivors().size(), significant);
  EXPECT_GE(significant, 20u);
  EXPECT_FLOAT_EQ(support.weights()[0], 0.5F);
  EXPECT_FLOAT_EQ(support.weights()[149], 1.0F);
}

TEST(LocalSupport, SeparatesTwoMotions) {
  std::vector<int> motion;
  const Scene scene = twoMotions(1000, 5, motion);
  const LocalSupport support = supportOf(scene.matches);
  std::size_t found[3] = {}, all[3] = {};
  for (std::size_t i = 0; i < motion.size(); ++i) {
    ++all[motion[i]];
    found[motion[i]] += support.local()[i];
  }
  EXPECT_GE(found[0], all[0] * 9 / 10);
  EXPECT_GE(found[1], all[1] * 9 / 10);
  EXPECT_LE(found[2], all[2] * 3 / 100);
  // The maps of the survivors are those of their motions.
  std::size_t close = 0, right = 0;
  for (const std::uint32_t row : support.survivors()) {
    if (motion[row] == 2) continue;
    ++right;
    const double a = motion[row] == 0 ? 1.1 : 0.8, b = motion[row] == 0 ? 0.2 : -0.1;
    close += std::hypot(support.maps()[row][0] - a, support.maps()[row][1] - b) < 0.1 ? 1 : 0;
  }
  EXPECT_GE(close, right * 9 / 10);
}

TEST(LocalSupport, LocalMembersWithoutAHypothesisHaveTheMapOfASurvivor) {
  // With 5000 matches only the 200 best ones have hypotheses.
  Scene scene = homographyScene({5000, 0.5, 1.0, 15});
  addFrames(scene, 0.02);
  const LocalSupport support = supportOf(scene.matches);
  std::size_t members = 0, close = 0;
  for (const std::uint32_t row : selectedRows(support.local())) {
    if (support.support()[row] > 0 || scene.inlier[row] == 0) continue;
    ++members;
    const LinearMap& map = support.maps()[row];
    const cv::Point2d there =
        projected(scene.model, scene.matches.left_x[row] + 10, scene.matches.left_y[row]);
    const cv::Point2d here = projected(scene.model, scene.matches.left_x[row], scene.matches.left_y[row]);
    close += std::hypot(10 * map[0] - (there - here).x, 10 * map[2] - (there - here).y) < 1.5 ? 1 : 0;
  }
  EXPECT_GE(members, 2000u);
  EXPECT_GE(close, members * 95 / 100);
}

TEST(LocalSupport, FindsSmallGroupsAmongManyMatches) {
  // An object that covers 2 % of the left image moves by itself. With 8000 matches only the 125 best ones
  // have hypotheses at first; two or three of them are the object's.
  double found = 0, all = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Random random(seed);
    Scene scene;
    scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
    std::vector<std::uint8_t> object;
    for (std::size_t i = 0; i < 8000; ++i) {
      const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
      const bool inlier = i % 2 == 0;
      object.push_back(inlier && left.x >= 300 && left.x < 400 && left.y >= 200 && left.y < 296 ? 1 : 0);
      cv::Point2d right = left + cv::Point2d(15, 5);
      if (object.back() != 0) right += cv::Point2d(60, -40);
      right = inlier ? right + 0.5 * normalPoint(random) : uniformPoint(random, kSceneWidth, kSceneHeight);
      addMatch(scene, random, left, right, inlier);
    }
    const LocalSupport support = supportOf(scene.matches);
    for (std::size_t i = 0; i < object.size(); ++i) {
      all += object[i];
      found += object[i] * support.local()[i];
    }
    EXPECT_GE(share(support.local(), scene.inlier, 1), 0.95);
  }
  EXPECT_GE(found, 0.8 * all) << found << " of " << all;
}

TEST(LocalSupport, FindsNothingAmongOutliers) {
  for (const bool frames : {false, true}) {
    int with_survivors = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      Scene scene = homographyScene({800, 0, 1.0, seed});
      if (frames) addFrames(scene, 0.05, seed);
      const LocalSupport support = supportOf(scene.matches);
      with_survivors += support.survivors().empty() ? 0 : 1;
      if (support.survivors().empty()) {
        EXPECT_EQ(support.localSize(), 0u);
      }
    }
    EXPECT_LE(with_survivors, 1) << (frames ? "with frames" : "without frames");
  }
}

TEST(LocalSupport, HubsAndRepetitionsGainNothing) {
  // Outliers that end at five right points, and one outlier that occurs a hundred times.
  Scene scene = homographyScene({600, 0, 1.0, 7});
  addFrames(scene);
  Random random(8);
  const cv::Point2f hubs[] = {{320, 240}, {324, 240}, {320, 245}, {326, 246}, {316, 243}};
  for (std::size_t i = 0; i < 300; ++i) {
    const cv::Point2f hub = hubs[random.index(5)];
    scene.matches.right_x[i] = hub.x;
    scene.matches.right_y[i] = hub.y;
    // A frame that squeezes the left image into the hub.
    scene.matches.right_frame[i] = {0.02F, 0, hub.x, 0, 0.02F, hub.y};
    scene.matches.left_frame[i] = {1, 0, scene.matches.left_x[i], 0, 1, scene.matches.left_y[i]};
  }
  std::vector<std::uint32_t> rows(600);
  std::iota(rows.begin(), rows.end(), 0U);
  rows.insert(rows.end(), 100, 599U);
  const LocalSupport support = supportOf(scene.matches.subset(rows));
  EXPECT_TRUE(support.survivors().empty());
  EXPECT_FLOAT_EQ(support.weights()[699], 1.0F / 101);
}

TEST(LocalSupport, DoesNotDependOnTheOrderOfTheInputNorOnThreads) {
  for (const bool distances : {true, false}) {
    for (const bool frames : {true, false}) {
      Scene scene = homographyScene({3000, 0.3, 1.0, 9});
      if (frames) addFrames(scene);
      Correspondences& m = scene.matches;
      if (!distances) {
        m.distance.clear();
        m.second_distance.clear();
      } else {
        for (float& distance : m.distance) distance = std::round(distance / 50) * 50;  // many ties
        m.second_distance.assign(m.size(), 200);
      }
      const LocalSupport expected = supportOf(m);
      const std::vector<std::uint32_t> order = permutation(m.size(), 10);
      for (const int threads : {1, 3}) {
        const LocalSupport support = supportOf(m.subset(order), threads);
        EXPECT_EQ(support.support(), reordered(expected.support(), order));
        EXPECT_EQ(support.maps(), reordered(expected.maps(), order));
        EXPECT_EQ(support.local(), reordered(expected.local(), order));
        EXPECT_EQ(support.extended(), reordered(expected.extended(), order));
        EXPECT_EQ(support.weights(), reordered(expected.weights(), order));
        ASSERT_EQ(support.survivors().size(), expected.survivors().size());
        for (std::size_t i = 0; i < expected.survivors().size(); ++i)
          EXPECT_EQ(order[support.survivors()[i]], expected.survivors()[i]);
      }
    }
  }
}

TEST(LocalSupport, IsTheSameAtEveryKernelLevel) {
  LevelGuard guard;
  Scene scene = homographyScene({1777, 0.3, 1.0, 11});
  addFrames(scene);
  setKernelLevel(KernelLevel::kPlain);
  const LocalSupport expected = supportOf(scene.matches);
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    const LocalSupport support = supportOf(scene.matches);
    EXPECT_EQ(support.support(), expected.support()) << toString(level);
    EXPECT_EQ(support.maps(), expected.maps()) << toString(level);
    EXPECT_EQ(support.local(), expected.local()) << toString(level);
  }
}

TEST(LocalSupport, SurvivesDegenerateInput) {
  for (const std::size_t n : {0, 1, 2, 3, 9, 17}) {
    Scene scene = homographyScene({n, 1.0, 1.0, 12});
    EXPECT_EQ(supportOf(scene.matches).support().size(), n);
    addFrames(scene);
    EXPECT_EQ(supportOf(scene.matches).support().size(), n);
  }
  Scene scene = homographyScene({200, 0.5, 1.0, 13});
  addFrames(scene);
  const auto expectFinite = [](const Correspondences& matches) {
    const LocalSupport support = supportOf(matches);
    for (std::size_t i = 0; i < support.support().size(); ++i) {
      EXPECT_TRUE(std::isfinite(support.support()[i]) && support.support()[i] >= 0);
      for (const float element : support.maps()[i]) EXPECT_TRUE(std::isfinite(element));
    }
    return support;
  };
  Correspondences same = scene.matches;
  same.left_x.assign(200, 5);
  same.left_y.assign(200, 5);
  EXPECT_TRUE(expectFinite(same).survivors().empty());
  same = scene.matches;
  same.right_x.assign(200, 5);
  same.right_y.assign(200, 5);
  EXPECT_TRUE(expectFinite(same).survivors().empty());
  same.right_size = {0, 0};
  EXPECT_TRUE(expectFinite(same).survivors().empty());
  Correspondences frames = scene.matches;
  for (std::size_t i = 0; i < 200; i += 2) frames.left_frame[i] = AffineFrame{};
  for (std::size_t i = 1; i < 200; i += 2) frames.right_frame[i].fill(kNaN);
  EXPECT_GE(expectFinite(frames).survivors().size(), 50u) << "partners give maps where frames do not";
  Correspondences far = scene.matches;
  for (float& x : far.right_x) x *= 1e18F;
  expectFinite(far);
  far.left_x = far.right_x;
  expectFinite(far);
  Correspondences line = scene.matches;
  line.left_y = line.left_x;
  expectFinite(line);
  Correspondences identical = scene.matches;
  identical.right_x = identical.left_x;
  identical.right_y = identical.left_y;
  identical.left_frame.clear();
  identical.right_frame.clear();
  EXPECT_GE(expectFinite(identical).localSize(), 198u);
}

TEST(LocalSupport, TakesTheExtentOfThePointsWhereTheImageSizeIsUnknown) {
  Scene scene = homographyScene({1000, 0.5, 1.0, 14});
  EXPECT_NEAR(supportOf(scene.matches).diagonal(), 1000, 1e-6);
  scene.matches.left_size = scene.matches.right_size = {0, 0};
  const LocalSupport support = supportOf(scene.matches);
  EXPECT_NEAR(support.diagonal(), 1000, 10);
  EXPECT_GE(share(support.local(), scene.inlier, 1), 0.95);
}

}  // namespace
}  // namespace corrsel::core
