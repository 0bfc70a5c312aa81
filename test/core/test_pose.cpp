#include <gtest/gtest.h>

#include "corrsel/selectors/pose.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

TEST(Pose, NeedsBothCameras) {
  Correspondences matches;
  matches.add({1, 2}, {3, 4});
  const Selection selection = PoseSelector().select(matches);
  EXPECT_EQ(selection.status, Status::kUnsupportedInput);
  EXPECT_TRUE(testing::contains(selection.message, "left camera")) << selection.message;
}

}  // namespace
}  // namespace corrsel::core
