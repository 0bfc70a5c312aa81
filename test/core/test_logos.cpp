#include <gtest/gtest.h>

#include "corrsel/reference/logos.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Matches on a grid of 50 px under a similarity, with exact frames.
Scene similarityScene(double angle, double scale, int side = 10) {
  Scene scene;
  const double c = scale * std::cos(angle), s = scale * std::sin(angle);
  scene.model = cv::Matx33d(c, -s, 300, s, c, 300, 0, 0, 1);
  scene.matches.left_size = scene.matches.right_size = {kSceneWidth, kSceneHeight};
  Random random(1);
  for (int i = 0; i < side * side; ++i) {
    // The shear keeps distances from being equal.
    const double y = 50 * (i / side), x = 51.3 * (i % side) + 0.07 * y;
    const cv::Point2d right = projected(scene.model, x, y);
    addMatch(scene, random, {x, y}, right, true);
  }
  addFrames(scene, 0);
  return scene;
}

/// Replaces the right frame of a match: turned and scaled further.
void turnFrame(Scene& scene, std::size_t i, double angle, double scale) {
  AffineFrame& f = scene.matches.right_frame[i];
  const float c = float(scale * std::cos(angle)), s = float(scale * std::sin(angle));
  f = {c * f[0] - s * f[3], c * f[1] - s * f[4], f[2], s * f[0] + c * f[3], s * f[1] + c * f[4], f[5]};
}

TEST(Logos, AcceptsUpToTheLargestDifference) {
  // Near pi, rotations wrap around.
  for (const double angle : {0.0, 0.5, -1.0, 3.1, -3.1}) {
    for (const double scale : {0.5, 1.0, 2.0}) {
      Scene scene = similarityScene(angle, scale);
      EXPECT_EQ(LogosSelector().select(scene.matches).n_selected, 100u) << angle << " " << scale;
      turnFrame(scene, 44, 0.28, 1);
      turnFrame(scene, 55, 0.32, 1);
      turnFrame(scene, 22, 0, std::exp(0.28));
      turnFrame(scene, 77, 0, std::exp(0.32));
      const Selection s = LogosSelector().select(scene.matches);
      EXPECT_EQ(s.mask[44], 1);
      EXPECT_EQ(s.mask[55], 0);
      EXPECT_EQ(s.mask[22], 1);
      EXPECT_EQ(s.mask[77], 0);
      EXPECT_EQ(s.n_selected, 98u);
    }
  }
}

TEST(Logos, VectorsMustTurnLikeTheFrames) {
  // All frames turn alike, but the points do not.
  Scene scene = similarityScene(0.5, 1);
  for (std::size_t i = 0; i < 100; ++i) turnFrame(scene, i, 0.32, 1);
  EXPECT_EQ(LogosSelector().select(scene.matches).n_selected, 0u);
  scene = similarityScene(0.5, 1);
  for (std::size_t i = 0; i < 100; ++i) turnFrame(scene, i, 0, std::exp(-0.32));
  EXPECT_EQ(LogosSelector().select(scene.matches).n_selected, 0u);
}

TEST(Logos, SupportComesFromNeighboursInBothImages) {
  // In the middle of the grid, the four nearest neighbours are the same in both images.
  const Scene scene = similarityScene(0.5, 1.2);
  const Selection s = createSelector("logos", {{"k", "4"}})->select(scene.matches);
  EXPECT_EQ(s.score[44], 4.0F);
  EXPECT_EQ(s.score[0], 4.0F);
  // A match that goes elsewhere loses its neighbours in the right image.
  Scene moved = scene;
  moved.matches.right_x[44] += 300;
  const Selection without = createSelector("logos", {{"k", "4"}})->select(moved.matches);
  EXPECT_EQ(without.score[44], 0.0F);
  EXPECT_EQ(without.mask[44], 0);
  EXPECT_EQ(without.score[43], 3.0F);
}

TEST(Logos, ACrowdAtARightPointIsOneNeighbour) {
  // 25 matches, more than k, go to a point beside that of match 44.
  Scene scene = similarityScene(0.5, 1.2);
  const Selection before = createSelector("logos", {{"k", "8"}})->select(scene.matches);
  Correspondences& m = scene.matches;
  for (std::size_t i = 0; i < 25; ++i) {
    m.left_x.push_back(2000 + 10 * float(i));
    m.left_y.push_back(2000 + 7 * float(i % 5));
    m.right_x.push_back(m.right_x[44] + 5 + 0.01F * float(i));
    m.right_y.push_back(m.right_y[44] + 5);
    m.distance.push_back(1);
    m.second_distance.push_back(2);
    m.left_frame.push_back(m.left_frame[0]);
    m.right_frame.push_back(m.right_frame[0]);
  }
  const Selection s = createSelector("logos", {{"k", "9"}})->select(m);
  EXPECT_GE(s.score[44], before.score[44]);
  EXPECT_EQ(s.mask[44], 1);
}

TEST(Logos, GlobalKeepsTheMostFrequentRotation) {
  Scene scene = similarityScene(3.1, 1);
  const Scene other = similarityScene(1.0, 1, 7);
  // 49 further matches, far away and with another rotation.
  Correspondences& m = scene.matches;
  for (std::size_t i = 0; i < 49; ++i) {
    m.left_x.push_back(other.matches.left_x[i] + 5000);
    m.left_y.push_back(other.matches.left_y[i]);
    m.right_x.push_back(other.matches.right_x[i] + 5000);
    m.right_y.push_back(other.matches.right_y[i]);
    m.distance.push_back(1);
    m.second_distance.push_back(2);
    m.left_frame.push_back(other.matches.left_frame[i]);
    m.right_frame.push_back(other.matches.right_frame[i]);
  }
  EXPECT_EQ(createSelector("logos", {{"global", "false"}})->select(m).n_selected, 149u);
  const Selection s = LogosSelector().select(m);
  EXPECT_EQ(s.n_selected, 100u);
  EXPECT_EQ(s.mask[100], 0);
}

TEST(Logos, FindsAPlaneAmongOutliers) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Scene scene = homographyScene({1500, 0.3, 1.0, seed});
    addFrames(scene, 0.05, seed);
    const Quality q = quality(LogosSelector().select(scene.matches).mask, scene.inlier);
    EXPECT_GE(q.precision, 95);
    EXPECT_GE(q.recall, 90);
  }
}

TEST(Logos, DecidesDegenerateInput) {
  Scene scene = similarityScene(0.2, 1);
  const LogosSelector logos;
  EXPECT_EQ(logos.select({}).status, Status::kOk);
  EXPECT_EQ(logos.select(scene.matches.subset({0})).n_selected, 0u);
  EXPECT_EQ(logos.select(scene.matches.subset({0, 1})).n_selected, 2u);
  Correspondences m = scene.matches;
  m.left_x.assign(100, 5);
  m.left_y.assign(100, 6);
  EXPECT_EQ(logos.select(m).status, Status::kDegenerate);
  m = scene.matches;
  m.left_frame.assign(100, {0, 0, 0, 0, 0, 0});
  EXPECT_EQ(logos.select(m).status, Status::kDegenerate);
  m = scene.matches;
  m.left_frame[3] = {0, 0, 0, 0, 0, 0};
  const Selection s = logos.select(m);
  EXPECT_EQ(s.message, "1 matches have no usable frames");
  EXPECT_TRUE(std::isnan(s.score[3]));
  EXPECT_EQ(s.n_selected, 99u);
  m.right_frame.clear();
  EXPECT_EQ(logos.select(m).message, "logos needs the local affine frames of the right features");
  // Copies of a match do not support it.
  EXPECT_EQ(logos.select(scene.matches.subset({0, 0, 0})).n_selected, 0u);
  // Identical images.
  m = scene.matches;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  m.right_frame = m.left_frame;
  EXPECT_EQ(logos.select(m).n_selected, 100u);
}

}  // namespace
}  // namespace corrsel::core
