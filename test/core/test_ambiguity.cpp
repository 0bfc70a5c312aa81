#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "corrsel/database/ambiguity.h"
#include "corrsel/selectors/factory.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Shares of all matches; the rest are outliers.
struct FacadeOptions {
  double right = 0.4;
  double shifted = 0.2;
  int periods = 1;
  bool vertical = false;
  double depth = 0;  ///< of what lies behind the wall, in periods
  std::size_t n = 600;
};

cv::Matx33d turned(double angle) {
  return {std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)};
}

/// A facade with equal windows, seen from two sides. Each window has the same 14 features. Some matches end
/// some windows further.
Correspondences facade(const FacadeOptions& options, std::uint64_t seed) {
  Random random(seed);
  const cv::Matx33d camera(900, 0, 512, 0, 900, 384, 0, 0, 1), tilt = turned(0.4), motion = turned(-0.1);
  std::vector<cv::Vec3d> features(14);
  for (cv::Vec3d& feature : features) {
    const cv::Point2d place = uniformPoint(random, 1, 1);
    feature = {place.x, place.y, random.index(2) == 0 ? 0 : options.depth};
  }
  const auto project = [&](cv::Vec3d point, bool left) {
    point = tilt * point + cv::Vec3d(0, 0, 12);
    if (!left) point = motion * point + cv::Vec3d(1.5, 0.1, 0.2);
    const cv::Vec3d p = camera * point;
    return cv::Point2d(p[0] / p[2], p[1] / p[2]) + 0.5 * normalPoint(random);
  };
  const auto visible = [](const cv::Point2d& p) { return p.x >= 0 && p.y >= 0 && p.x < 1024 && p.y < 768; };
  Correspondences matches;
  matches.left_size = matches.right_size = {1024, 768};
  while (matches.size() < options.n) {
    const double kind = random.uniform();
    cv::Point2d left = uniformPoint(random, 1024, 768), right = uniformPoint(random, 1024, 768);
    if (kind < options.right + options.shifted) {
      const cv::Point2d window = uniformPoint(random, 21, 15);
      cv::Vec3d point =
          features[random.index(14)] + cv::Vec3d(std::floor(window.x) - 10, std::floor(window.y) - 7, 0);
      left = project(point, true);
      if (kind >= options.right) point[options.vertical ? 1 : 0] += options.periods;
      right = project(point, false);
    }
    if (visible(left) && visible(right)) matches.add(left, right);
  }
  return matches;
}

double ambiguityOf(const Correspondences& matches, const std::string& selector = "auto") {
  return ambiguity(matches, createSelector(selector)->select(matches), Workspace::ofThread());
}

TEST(Ambiguity, AShiftedFacadeIsMarked) {
  int marked = 0, pairs = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    for (const bool vertical : {false, true}) {
      for (const double depth : {0.0, 0.3}) {
        FacadeOptions options;
        options.periods = 1 + int(seed) % 3;
        options.vertical = vertical;
        options.depth = depth;
        const double some = ambiguityOf(facade(options, seed));
        options.shifted = 0.35;
        const double many = ambiguityOf(facade(options, seed));
        marked += (some > 0.25 && some < 0.75 ? 1 : 0) + (many > 0.55 ? 1 : 0);
        pairs += 2;
      }
    }
  }
  EXPECT_GE(marked, pairs - 2) << "of " << pairs;
}

TEST(Ambiguity, WithCamerasAShiftedFacadeIsMarked) {
  Correspondences matches = facade({}, 3);
  Camera camera;
  camera.matrix = cv::Matx33d(900, 0, 512, 0, 900, 384, 0, 0, 1);
  camera.size = matches.left_size;
  matches.left_camera = matches.right_camera = camera;
  EXPECT_GT(ambiguityOf(matches), 0.25);
}

TEST(Ambiguity, AFundamentalMatrixThatHidesTheShiftIsMarked) {
  // A plane and its shifted copy look like two parallel planes: one fundamental matrix explains both.
  FacadeOptions options;
  options.shifted = 0.3;
  const Correspondences matches = facade(options, 1);
  const Selection selection = createSelector("auto")->select(matches);
  ASSERT_EQ(selection.model_kind, ModelKind::kFundamental);
  ASSERT_GT(selection.n_selected, matches.size() / 2);
  EXPECT_GT(ambiguity(matches, selection, Workspace::ofThread()), 0.4);
}

TEST(Ambiguity, AFacadeWithoutShiftIsNot) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    FacadeOptions options;
    options.shifted = 0;
    options.depth = seed % 2 == 0 ? 0 : 0.3;
    EXPECT_EQ(ambiguityOf(facade(options, seed)), 0) << seed;
    // All matches follow the shift: there is nothing to compare it with.
    options.right = 0;
    options.shifted = 0.4;
    EXPECT_EQ(ambiguityOf(facade(options, seed)), 0) << seed;
  }
}

TEST(Ambiguity, PlanesAndSpaceWithOutliersAreNot) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (const double ratio : {0.3, 0.7}) {
      SceneOptions options;
      options.n = 800;
      options.inlier_ratio = ratio;
      options.seed = seed;
      EXPECT_EQ(ambiguityOf(homographyScene(options).matches), 0) << seed << ' ' << ratio;
      EXPECT_LT(ambiguityOf(stereoScene(options).matches), 0.2) << seed << ' ' << ratio;
    }
  }
}

/// A background at rest and a square that moves in front of it.
Correspondences movingSquare(double side, std::uint64_t seed) {
  Random random(seed);
  Correspondences matches;
  matches.left_size = matches.right_size = {1024, 768};
  const auto inside = [side](const cv::Point2d& p, const cv::Point2d& corner) {
    return p.x >= corner.x && p.x < corner.x + side && p.y >= corner.y && p.y < corner.y + side;
  };
  const cv::Point2d from(300, 250), to(420, 210);
  while (matches.size() < 500) {
    const cv::Point2d left = uniformPoint(random, 1024, 768);
    const cv::Point2d right = inside(left, from) ? left + to - from : left;
    if (!inside(left, from) && inside(right, to)) continue;  // hidden
    matches.add(left, right + 0.5 * normalPoint(random));
  }
  while (matches.size() < 700) {
    const cv::Point2d left = uniformPoint(random, 1024, 768);
    matches.add(left, uniformPoint(random, 1024, 768));
  }
  return matches;
}

TEST(Ambiguity, AnObjectThatMovesIsNot) {
  for (const double side : {200.0, 300.0, 400.0})
    for (std::uint64_t seed = 0; seed < 6; ++seed)
      EXPECT_EQ(ambiguityOf(movingSquare(side, seed)), 0) << side << ' ' << seed;
}

TEST(Ambiguity, IsTheSameInAnyOrder) {
  for (const double shifted : {0.15, 0.3}) {
    FacadeOptions options;
    options.shifted = shifted;
    options.n = 1500;  // more than are examined
    const Correspondences matches = facade(options, 5);
    const Selection selection = createSelector("auto")->select(matches);
    const double expected = ambiguity(matches, selection, Workspace::ofThread());
    EXPECT_GT(expected, 0);
    const auto order = permutation(matches.size(), 6);
    Selection other = selection;
    other.mask = reordered(selection.mask, order);
    Workspace workspace;
    EXPECT_EQ(ambiguity(matches.subset(order), other, workspace), expected);
    EXPECT_EQ(ambiguity(matches, selection, workspace), expected);
  }
}

TEST(Ambiguity, UnusableMatchesAreIgnored) {
  Correspondences matches = facade({}, 7);
  const Selection selection = createSelector("auto")->select(matches);
  const double expected = ambiguity(matches, selection, Workspace::ofThread());
  Selection more = selection;
  for (const float value : {std::nanf(""), INFINITY, -INFINITY, 1e30F}) {
    matches.add({value, 3}, {5, 6});
    matches.add({3, 5}, {6, value});
    more.mask.insert(more.mask.end(), 2, 0);
  }
  EXPECT_EQ(ambiguity(matches, more, Workspace::ofThread()), expected);
}

TEST(Ambiguity, WithoutASelectionItIsNotExamined) {
  Selection none;
  EXPECT_TRUE(std::isnan(ambiguity(Correspondences(), none, Workspace::ofThread())));
  const Correspondences matches = facade({}, 8);
  none.mask.assign(matches.size(), 0);
  EXPECT_TRUE(std::isnan(ambiguity(matches, none, Workspace::ofThread())));
  // Few selected matches, all of them at one point, and a model that maps to infinity.
  Selection few;
  few.mask.assign(matches.size(), 0);
  few.mask[4] = 1;
  EXPECT_EQ(ambiguity(matches, few, Workspace::ofThread()), 0);
  few.model_kind = ModelKind::kHomography;
  EXPECT_EQ(ambiguity(matches, few, Workspace::ofThread()), 0);
}

}  // namespace
}  // namespace corrsel::core
