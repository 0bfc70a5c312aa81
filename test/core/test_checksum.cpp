#include <gtest/gtest.h>

#include "base/checksum.h"

namespace corrsel::core {
namespace {

Checksum checksumOf(const std::string& text) {
  Checksum checksum;
  checksum.add(text);
  return checksum;
}

TEST(Checksum, HasThePublishedValues) {
  EXPECT_EQ(checksumOf("").text(), "cbf29ce484222325");
  EXPECT_EQ(checksumOf("a").text(), "af63dc4c8601ec8c");
  EXPECT_EQ(checksumOf("foobar").text(), "85944171f73967e8");
  EXPECT_EQ(checksumOf("foobar").value(), 0x85944171f73967e8ULL);
}

TEST(Checksum, PartsGiveTheValueOfTheWhole) {
  Checksum checksum;
  checksum.add("foo");
  checksum.add("bar", 3);
  EXPECT_EQ(checksum.value(), checksumOf("foobar").value());
}

TEST(Checksum, AUnitMayBeWiderThanAByte) {
  Checksum byte, word;
  byte.addUnit('a');
  EXPECT_EQ(byte.value(), checksumOf("a").value());
  word.addUnit(std::uint64_t{'a'} << 32U);
  EXPECT_NE(word.value(), byte.value());
}

TEST(Checksum, LeadingZerosOfTheTextRemain) {
  // The first unit turns the start value into 1, which the prime then becomes.
  Checksum checksum;
  checksum.addUnit(0xcbf29ce484222325ULL ^ 1U);
  EXPECT_EQ(checksum.text(), "00000100000001b3");
}

}  // namespace
}  // namespace corrsel::core
