#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <set>

#include "benchmark/scaling.h"

namespace corrsel::core {
namespace {

BenchmarkConfig quickConfig(int threads) {
  BenchmarkConfig config;
  config.bags = {"a.bag"};
  config.features = {"orb+orb"};
  config.selectors = {"nnsr", "gms", "st"};
  config.threads = threads;
  config.resolve();
  return config;
}

TEST(Scaling, EverySelectorSizeAndRoundWithTheThreadsThatItUses) {
  const std::atomic<bool> stop{false};
  const std::vector<ScalingRow> rows = measureScaling(quickConfig(2), stop);
  const std::size_t sizes = std::size(kScalingSizes);
  std::set<std::string> cells, series;
  for (const ScalingRow& row : rows) {
    cells.insert(row.selector + " " + std::to_string(row.threads) + " " + std::to_string(row.n) + " " +
                 std::to_string(row.round));
    series.insert(row.selector + " " + std::to_string(row.threads));
    EXPECT_EQ(row.status, Status::kOk) << row.selector;
    EXPECT_GT(row.n_selected, 0U);
    EXPECT_LE(row.n_selected, row.n);
    EXPECT_GE(row.select_seconds, 0.0);
  }
  EXPECT_EQ(cells.size(), rows.size());
  // keep_all, the baseline, is always there. What has no option `threads` is not measured twice.
  EXPECT_EQ(series, (std::set<std::string>{"gms 1", "keep_all 1", "nnsr 1", "st 1", "st 2"}));
  EXPECT_EQ(rows.size(), series.size() * sizes * kScalingRounds);
  // What is selected depends on neither threads nor time.
  for (const ScalingRow& row : rows) {
    for (const ScalingRow& other : rows) {
      if (other.selector == row.selector && other.n == row.n && other.round == row.round) {
        EXPECT_EQ(other.n_selected, row.n_selected);
      }
    }
  }
}

TEST(Scaling, StoppedGivesNothing) {
  const std::atomic<bool> stop{true};
  EXPECT_TRUE(measureScaling(quickConfig(1), stop).empty());
}

}  // namespace
}  // namespace corrsel::core
