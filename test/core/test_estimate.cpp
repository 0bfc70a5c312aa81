#include <gtest/gtest.h>

#include <regex>
#include <string>

#include "benchmark/estimate.h"

namespace corrsel::core {
namespace {

/// Four of a hundred pairs.
Trial someTrial() {
  Trial trial;
  trial.name = "vgg";
  trial.pairs = 100;
  trial.selections = 4 * 21;
  trial.run = {4, 8.0, 4096.0};
  trial.pictures = {10, 1.0, 10240.0};
  return trial;
}

TEST(Estimate, IsInProportionToTheTrial) {
  const Estimate estimate = estimateOf(someTrial());
  EXPECT_EQ(estimate.pairs, 100U);
  EXPECT_DOUBLE_EQ(estimate.selections, 2100);
  EXPECT_DOUBLE_EQ(estimate.seconds, 200);
  EXPECT_DOUBLE_EQ(estimate.run_bytes, 102400);
}

TEST(Estimate, PicturesAreDrawnOfFewPairs) {
  Trial few = someTrial();
  few.pairs = 5;
  EXPECT_EQ(maxPictures({few}, 7), 5U * 7);
  EXPECT_EQ(maxPictures({someTrial(), someTrial()}, 7), (16U + 2 * 3) * 7);
}

TEST(Estimate, TableHasALineForEachDatasetAndTheSum) {
  Trial unreadable;
  unreadable.name = "broken";
  unreadable.pairs = 3;
  const std::string table =
      std::regex_replace(estimateTable({someTrial(), unreadable}, 20), std::regex(" +"), " ");
  EXPECT_EQ(table,
            " pairs selections time folder\n"
            "vgg 100 2100 3:20 100 KiB\n"
            "broken 3 ? ? ?\n"
            "at most 20 pictures 0:02 20 KiB\n"
            "sum 103 2100 3:22 120 KiB\n");
}

}  // namespace
}  // namespace corrsel::core
