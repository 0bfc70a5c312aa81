#include <gtest/gtest.h>

#include "corrsel/reference/frame_votes.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

const char* const kSpecs[] = {"frame_votes:hviv", "frame_votes:acc"};

TEST(FrameVotes, FindsAPlaneAmongOutliers) {
  for (const char* spec : kSpecs) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      Scene scene = homographyScene({1500, 0.3, 1.0, seed});
      addFrames(scene, 0.05, seed);
      EXPECT_GE(quality(createSelector(spec)->select(scene.matches).mask, scene.inlier).f, 95) << spec;
    }
  }
}

/// Two similarities of 100 matches each, in halves of the image, and 300 outliers.
Scene twoGroups(std::uint64_t seed) {
  Scene scene = homographyScene({100, 1.0, 1.0, seed}), other = scene,
        wrong = homographyScene({300, 0.0, 1.0, seed});
  Random random(seed);
  Scene result;
  result.matches.left_size = result.matches.right_size = {kSceneWidth, kSceneHeight};
  const cv::Matx33d models[] = {cv::Matx33d(0.8, -0.3, 150, 0.3, 0.8, 20, 0, 0, 1),
                                cv::Matx33d(0.5, 0.5, -150, -0.5, 0.5, 450, 0, 0, 1)};
  std::vector<AffineFrame> left, right;
  for (int group = 0; group < 2; ++group) {
    Scene part;
    part.model = models[group];
    for (int i = 0; i < 100; ++i) {
      const cv::Point2d p = uniformPoint(random, 350, 500) + cv::Point2d(group * 400, 50);
      addMatch(part, random, p, projected(part.model, p.x, p.y) + normalPoint(random), true);
    }
    addFrames(part, 0.05, seed);
    for (std::uint32_t i = 0; i < 100; ++i) {
      addMatch(result, random, {part.matches.left_x[i], part.matches.left_y[i]},
               {part.matches.right_x[i], part.matches.right_y[i]}, true);
    }
    left.insert(left.end(), part.matches.left_frame.begin(), part.matches.left_frame.end());
    right.insert(right.end(), part.matches.right_frame.begin(), part.matches.right_frame.end());
  }
  addFrames(wrong, 0.05, seed);
  for (std::uint32_t i = 0; i < 300; ++i) {
    addMatch(result, random, {wrong.matches.left_x[i], wrong.matches.left_y[i]},
             {wrong.matches.right_x[i], wrong.matches.right_y[i]}, false);
  }
  left.insert(left.end(), wrong.matches.left_frame.begin(), wrong.matches.left_frame.end());
  right.insert(right.end(), wrong.matches.right_frame.begin(), wrong.matches.right_frame.end());
  result.matches.left_frame = left;
  result.matches.right_frame = right;
  return result;
}

TEST(FrameVotes, FindsTwoMotions) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = twoGroups(seed);
    const Quality q = quality(createSelector("frame_votes:acc")->select(scene.matches).mask, scene.inlier);
    EXPECT_GE(q.precision, 95);
    EXPECT_GE(q.recall, 95);
  }
}

TEST(FrameVotes, NumbersTheClusters) {
  Scene scene = twoGroups(1);
  // The second cluster is the smaller one.
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < scene.matches.size(); ++i) {
    if (i < 100 || i >= 140) rows.push_back(i);
  }
  const Selection s = createSelector("frame_votes:acc")->select(scene.matches.subset(rows));
  ASSERT_EQ(s.group.size(), rows.size());
  std::size_t found[2] = {};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(s.mask[i] != 0, s.group[i] >= 0);
    if (s.group[i] < 0 || i >= 160) continue;
    EXPECT_EQ(s.group[i], i < 100 ? 0 : 1) << i;
    ++found[s.group[i]];
  }
  EXPECT_GE(found[0], 90u);
  EXPECT_GE(found[1], 50u);
  EXPECT_TRUE(createSelector("frame_votes:hviv")->select(scene.matches).group.empty());
  EXPECT_TRUE(
      createSelector("frame_votes:acc", {{"min_members", "1000"}})->select(scene.matches).group.empty());
}

TEST(FrameVotes, ClustersNeedDistinctRightPoints) {
  // A crowd of left points that are sent to one right point agrees with itself under maps that shrink.
  Scene scene = homographyScene({30, 1.0, 0.0, 5});
  Correspondences& m = scene.matches;
  addFrames(scene);
  for (std::size_t i = 0; i < 30; ++i) {
    m.right_x[i] = 300 + 0.1F * float(i % 3);
    m.right_y[i] = 200;
    m.left_frame[i] = {50, 0, 0, 0, 50, 0};
    m.right_frame[i] = {1, 0, 0, 0, 1, 0};
  }
  const Selection s = createSelector("frame_votes:acc", {{"cut", "1000"}})->select(m);
  EXPECT_EQ(s.n_selected, 0u);
  EXPECT_EQ(s.message, "no cluster has 10 distinct right points");
}

TEST(FrameVotes, TranslationsNeedNoFrames) {
  const Scene scene = homographyScene({1500, 0.6, 0.5, 6});
  const Selection without = FrameVotesSelector().select(scene.matches);
  EXPECT_EQ(without.status, Status::kUnsupportedInput);
  EXPECT_EQ(without.message, "frame_votes needs the local affine frames of the left features");
  for (const char* spec : kSpecs) {
    const auto selector = createSelector(spec, {{"maps", "translation"}});
    EXPECT_GE(quality(selector->select(scene.matches).mask, scene.inlier).f, 90) << spec;
  }
}

TEST(FrameVotes, ScoreAndOtsu) {
  Scene scene = homographyScene({1000, 0.4, 1.0, 7});
  addFrames(scene);
  const Selection s = FrameVotesSelector().select(scene.matches);
  EXPECT_EQ(*std::max_element(s.score.begin(), s.score.end()), 1.0F);
  for (std::size_t i = 0; i < s.score.size(); ++i) ASSERT_EQ(s.mask[i] == 1, s.score[i] > 0.25F);
  const Selection otsu = createSelector("frame_votes", {{"share", "0"}})->select(scene.matches);
  EXPECT_GE(quality(otsu.mask, scene.inlier).f, 90);
  EXPECT_NE(otsu.mask, s.mask);
}

TEST(FrameVotes, DecidesDegenerateInput) {
  Scene scene = homographyScene({60, 1.0, 0.0, 8});
  addFrames(scene);
  for (const char* spec : kSpecs) {
    const auto selector = createSelector(spec);
    EXPECT_EQ(selector->select({}).status, Status::kOk) << spec;
    EXPECT_EQ(selector->select(scene.matches.subset({0})).n_selected, 0u) << spec;
    Correspondences equal = scene.matches;
    equal.right_x.assign(60, 5);
    equal.right_y.assign(60, 6);
    Selection s = selector->select(equal);
    EXPECT_EQ(s.status, Status::kDegenerate) << spec;
    EXPECT_EQ(s.n_selected, 0u) << spec;
    Correspondences flat = scene.matches;
    flat.right_frame.assign(60, {0, 0, 0, 0, 0, 0});
    s = selector->select(flat);
    EXPECT_EQ(s.status, Status::kDegenerate) << spec;
    EXPECT_EQ(s.message, "no match has usable frames") << spec;
    flat = scene.matches;
    flat.right_frame[7] = {0, 0, 0, 0, 0, 0};
    s = selector->select(flat);
    EXPECT_EQ(s.message, "1 matches have no usable frames") << spec;
    EXPECT_TRUE(std::isnan(s.score[7])) << spec;
    EXPECT_EQ(s.mask[7], 0) << spec;
    EXPECT_GE(s.n_selected, 50u) << spec;
    // Identical images.
    Correspondences same = scene.matches;
    same.right_x = same.left_x;
    same.right_y = same.left_y;
    same.right_frame = same.left_frame;
    EXPECT_EQ(selector->select(same).n_selected, 60u) << spec;
  }
  scene.matches.right_size = {};
  EXPECT_EQ(createSelector("frame_votes:hviv")->select(scene.matches).message,
            "frame_votes needs the size of the right image");
  EXPECT_EQ(createSelector("frame_votes:acc")->select(scene.matches).status, Status::kOk);
}

}  // namespace
}  // namespace corrsel::core
