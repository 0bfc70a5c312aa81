#include <gtest/gtest.h>

#include "selectors/parts/degenerate_input.h"

namespace corrsel::core {
namespace {

Correspondences twoMatches() {
  Correspondences m;
  m.add({1, 2}, {3, 4});
  m.add({5, 6}, {7, 8});
  return m;
}

TEST(DegenerateInput, EqualPointsOfEitherImageEndTheSelector) {
  Selection result;
  EXPECT_FALSE(endsAtEqualPoints(twoMatches(), result));
  EXPECT_EQ(result.status, Status::kOk);
  for (const bool left : {true, false}) {
    Correspondences m = twoMatches();
    (left ? m.left_x : m.right_x)[1] = (left ? m.left_x : m.right_x)[0];
    Selection half;
    EXPECT_FALSE(endsAtEqualPoints(m, half));  // y still differs
    (left ? m.left_y : m.right_y)[1] = (left ? m.left_y : m.right_y)[0];
    Selection equal;
    EXPECT_TRUE(endsAtEqualPoints(m, equal));
    EXPECT_EQ(equal.status, Status::kDegenerate);
    EXPECT_EQ(equal.message, "all points of an image are equal");
  }
}

TEST(DegenerateInput, FramesThatCannotBeUsedAreCounted) {
  Selection all, some, none, one;
  EXPECT_FALSE(endsAtFrames(twoMatches(), 2, all));
  EXPECT_EQ(all.message, "");
  EXPECT_FALSE(endsAtFrames(twoMatches(), 1, some));
  EXPECT_EQ(some.message, "1 matches have no usable frames");
  EXPECT_TRUE(endsAtFrames(twoMatches(), 0, none));
  EXPECT_EQ(none.status, Status::kDegenerate);
  EXPECT_EQ(none.message, "no match has usable frames");
  Correspondences single;
  single.add({1, 2}, {3, 4});
  EXPECT_FALSE(endsAtFrames(single, 1, one));  // one match has no others to differ from
}

TEST(DegenerateInput, MissingFramesAreNamed) {
  EXPECT_EQ(missingFrames({}, "gaim"), "");
  Correspondences m = twoMatches();
  EXPECT_EQ(missingFrames(m, "gaim"), "gaim needs the local affine frames of the left features");
  m.left_frame.resize(2);
  EXPECT_EQ(missingFrames(m, "gtm"), "gtm needs the local affine frames of the right features");
  m.right_frame.resize(2);
  EXPECT_EQ(missingFrames(m, "gtm"), "");
}

}  // namespace
}  // namespace corrsel::core
