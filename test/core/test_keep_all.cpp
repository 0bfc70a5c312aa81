#include <gtest/gtest.h>

#include <limits>

#include "corrsel/selectors/keep_all.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(KeepAll, KeepsEveryMatchWithUsableCoordinates) {
  Correspondences m;
  m.add({1, 2}, {3, 4});
  m.add({std::numeric_limits<float>::quiet_NaN(), 2}, {3, 4});
  m.add({5, 6}, {-7, 8});
  const Selection s = KeepAllSelector().select(m);
  EXPECT_EQ(s.mask, (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(s.status, Status::kOk);
  EXPECT_EQ(s.n_selected, 2u);
  EXPECT_EQ(s.n_ignored, 1u);
  EXPECT_EQ(KeepAllSelector().select({}).status, Status::kOk);
}

TEST(KeepAll, IsTheBaselineOnAdelaideRmf) {
  if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const Quality q = adelaideMeans("keep_all");
  EXPECT_NEAR(q.precision, 55.0, 0.1);
  EXPECT_EQ(q.recall, 100);
  EXPECT_NEAR(q.f, 69.6, 0.1);
}

}  // namespace
}  // namespace corrsel::core
