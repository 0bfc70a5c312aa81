#include <gtest/gtest.h>

#include <cstdint>

#include "base/large_array.h"

namespace corrsel::core {
namespace {

TEST(LargeArray, HoldsValuesUpToTheLast) {
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{1}, std::size_t{1} << 20, (std::size_t{1} << 20) + 1}) {
    const LargeArray<std::uint16_t> array = makeLargeArray<std::uint16_t>(count);
    ASSERT_NE(array, nullptr);
    for (std::size_t i = 0; i < count; ++i) array[i] = static_cast<std::uint16_t>(i);
    for (std::size_t i = 0; i < count; i += 1000) ASSERT_EQ(array[i], static_cast<std::uint16_t>(i));
  }
}

TEST(LargeArray, BeginsAtAHugePage) {
  const LargeArray<std::uint8_t> first = makeLargeArray<std::uint8_t>(100),
                                 second = makeLargeArray<std::uint8_t>(100);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first.get()) % (2U << 20), 0U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(second.get()) % (2U << 20), 0U);
}

}  // namespace
}  // namespace corrsel::core
