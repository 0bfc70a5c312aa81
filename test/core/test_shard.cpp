#include <gtest/gtest.h>

#include "corrsel/shard.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

TEST(Shard, ReadsAndRefuses) {
  EXPECT_EQ(Shard::fromText("").count, 1U);
  EXPECT_EQ(Shard::fromText("").text(), "");
  const Shard shard = Shard::fromText("2/3");
  EXPECT_EQ(shard.text(), "2/3");
  EXPECT_TRUE(shard.holds(1) && shard.holds(4) && !shard.holds(0) && !shard.holds(2));
  for (const char* wrong : {"0/3", "4/3", "2", "a/b", "1/0", "/", "1/2/3", "-1/3"}) {
    EXPECT_TRUE(contains(errorOf([&] { Shard::fromText(wrong); }), "shard")) << wrong;
  }
}

}  // namespace
}  // namespace corrsel::core
