#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "benchmark/examples.h"
#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr double kTau = 5;

ResultRow rowOf(const PairId& id, const std::string& selector, double f, double tau = kTau) {
  ResultRow row;
  row.id = id;
  row.features = "sift+sift";
  row.preselection = "none";
  row.selector = selector;
  row.n_ground_truth = 50;
  row.metrics.resize(1);
  row.metrics[0].tau = tau;
  row.metrics[0].f_paper = f;
  return row;
}

/// Rows of one dataset: F of the selectors a, b, c... on the pairs 0, 1, 2...
std::vector<ResultRow> table(const std::vector<std::vector<double>>& f, const std::string& dataset = "set") {
  std::vector<ResultRow> rows;
  for (std::size_t pair = 0; pair < f.size(); ++pair) {
    for (std::size_t s = 0; s < f[pair].size(); ++s) {
      rows.push_back(rowOf({dataset, "scene", std::to_string(pair)},
                           std::string(1, static_cast<char>('a' + s)), f[pair][s]));
    }
  }
  return rows;
}

std::vector<std::string> names(const std::vector<PairId>& ids) {
  std::vector<std::string> texts;
  for (const PairId& id : ids) texts.push_back(id.text());
  return texts;
}

std::vector<std::string> chosen(const std::vector<ResultRow>& rows, std::size_t max_pairs = 16) {
  return names(chooseExamples(rows, kTau, max_pairs));
}

using Names = std::vector<std::string>;

/// Whether every demand of the header is met by the pairs, computed from the definition.
void expectComplete(const std::vector<ResultRow>& rows, const std::vector<PairId>& pairs) {
  std::map<std::string, std::map<std::string, double>> f;  // by selector, then pair
  std::map<std::string, double> best;                      // by pair
  std::set<std::string> datasets, shown_datasets, shown;
  for (const ResultRow& row : rows) {
    f[row.selector][row.id.text()] = row.metrics[0].f_paper;
    best[row.id.text()] = std::max(best[row.id.text()], row.metrics[0].f_paper);
    datasets.insert(row.id.dataset);
  }
  for (const PairId& id : pairs) {
    shown.insert(id.text());
    shown_datasets.insert(id.dataset);
  }
  EXPECT_EQ(shown.size(), pairs.size());
  EXPECT_EQ(shown_datasets, datasets);
  for (const auto& [selector, values] : f) {
    double highest = 0, largest = 0;
    for (const auto& [pair, value] : values) {
      highest = std::max(highest, value);
      if (best[pair] >= 0.5) largest = std::max(largest, best[pair] - value);
    }
    double shown_highest = 0, shown_largest = 0;
    for (const std::string& pair : shown) {
      const double value = values.at(pair);
      shown_highest = std::max(shown_highest, value);
      if (best[pair] >= 0.5) shown_largest = std::max(shown_largest, best[pair] - value);
    }
    EXPECT_GE(shown_highest, std::min(0.8, highest)) << selector;
    EXPECT_GE(shown_largest, largest >= 0.3 ? 0.3 : 0.0) << selector;
  }
}

TEST(Examples, ThresholdsAreInclusive) {
  EXPECT_TRUE(isExampleSuccess(0.8));
  EXPECT_FALSE(isExampleSuccess(0.799));
  EXPECT_TRUE(isExampleFailure(0.2, 0.5));
  EXPECT_FALSE(isExampleFailure(0.1, 0.49));
  EXPECT_FALSE(isExampleFailure(0.7, 0.95));
  const double nan = kUndefined;
  EXPECT_FALSE(isExampleSuccess(nan) || isExampleFailure(nan, 0.9));
}

TEST(Examples, FewestPairsThatShowEverything) {
  // Pairs 1 and 3 show success and failure of both; the others show less.
  EXPECT_EQ(chosen(table({{0.6, 0.6}, {0.9, 0.1}, {0.85, 0.9}, {0.2, 0.95}})),
            (Names{"set/scene/1", "set/scene/3"}));
  // The strongest of several.
  EXPECT_EQ(chosen(table({{0.9, 0.5}, {0.99, 0.05}, {0.3, 0.85}, {0.01, 0.95}})),
            (Names{"set/scene/1", "set/scene/3"}));
}

TEST(Examples, WithoutSuccessOrFailureTheNearestThingIsShown) {
  // a never reaches 0.8: its best pair is 1. b is never far below: its largest shortfall is on pair 2.
  EXPECT_EQ(chosen(table({{0.40, 0.85}, {0.70, 0.80}, {0.60, 0.50}})),
            (Names{"set/scene/0", "set/scene/1", "set/scene/2"}));
  // A pair that defeats all is no failure of a, however far a is below the best.
  EXPECT_EQ(chosen(table({{0.0, 0.45}, {0.5, 0.9}, {0.95, 0.6}})), (Names{"set/scene/1", "set/scene/2"}));
}

TEST(Examples, EveryDatasetHasAPair) {
  std::vector<ResultRow> rows = table({{0.9, 0.1}, {0.1, 0.9}});
  for (const std::string dataset : {"other", "third"}) {
    const std::vector<ResultRow> more = table({{0.5, 0.5}, {0.6, 0.6}}, dataset);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  EXPECT_EQ(chosen(rows), (Names{"other/scene/0", "set/scene/0", "set/scene/1", "third/scene/0"}));
}

TEST(Examples, DegenerateTables) {
  EXPECT_TRUE(chosen({}).empty());
  EXPECT_EQ(chosen(table({{0.4}})), (Names{"set/scene/0"}));
  // One selector has no shortfall: its best and its worst pair.
  EXPECT_EQ(chosen(table({{0.5}, {0.3}, {0.7}})), (Names{"set/scene/1", "set/scene/2"}));
  // All alike: the first pair by name.
  EXPECT_EQ(chosen(table({{0.9, 0.9}, {0.9, 0.9}})), (Names{"set/scene/0"}));
}

TEST(Examples, WhatDoesNotCount) {
  const std::vector<ResultRow> rows = table({{0.9, 0.1}, {0.1, 0.9}});
  const Names expected = chosen(rows);
  std::vector<ResultRow> more = rows;
  const PairId id{"else", "scene", "9"};
  more.push_back(rowOf(id, "a", kUndefined));
  more.push_back(rowOf(id, "keep_all", 0.01));
  more.push_back(rowOf(id, "b", 1.0, 7));
  more.push_back(rowOf(id, "b", 1.0));
  more.back().status = Status::kUnsupportedInput;
  more.push_back(rowOf(id, "b", 1.0));
  more.back().status = Status::kFailed;
  EXPECT_EQ(chosen(more), expected);
  // Labelled rows have no tolerance and count.
  more.push_back(rowOf(id, "b", 0.5, kUndefined));
  EXPECT_EQ(chosen(more).front(), "else/scene/9");
}

TEST(Examples, RepetitionsAreAveraged) {
  std::vector<ResultRow> rows = table({{0.9}, {0.95}});
  // Pair 1 falls to 0.55 on average and becomes the worst.
  rows.push_back(rowOf({"set", "scene", "1"}, "a", 0.15));
  rows.push_back(rowOf({"set", "scene", "2"}, "a", 0.6));
  EXPECT_EQ(chosen(rows), (Names{"set/scene/0", "set/scene/1"}));
}

TEST(Examples, NumberIsBounded) {
  // Every selector succeeds on one pair of its own: all five are needed.
  std::vector<std::vector<double>> f(5, std::vector<double>(5, 0.1));
  for (std::size_t i = 0; i < f.size(); ++i) f[i][i] = 0.9;
  const std::vector<ResultRow> rows = table(f);
  EXPECT_EQ(chosen(rows).size(), 5U);
  EXPECT_EQ(chosen(rows, 3).size(), 3U);
  EXPECT_TRUE(chosen(rows, 0).empty());
}

TEST(Examples, RandomTablesAreCoveredWhateverTheOrderOfRows) {
  Random random(11);
  for (int round = 0; round < 200; ++round) {
    std::vector<ResultRow> rows;
    const std::uint32_t n_datasets = 1 + random.index(3), n_selectors = 1 + random.index(8);
    for (std::uint32_t d = 0; d < n_datasets; ++d) {
      std::vector<std::vector<double>> f(1 + random.index(12), std::vector<double>(n_selectors));
      for (std::vector<double>& pair : f) {
        // Coarse values make ties.
        for (double& value : pair) value = 0.05 * random.index(21);
      }
      const std::vector<ResultRow> more = table(f, "set" + std::to_string(d));
      rows.insert(rows.end(), more.begin(), more.end());
    }
    const std::vector<PairId> pairs = chooseExamples(rows, kTau, 1000);
    expectComplete(rows, pairs);
    EXPECT_LE(pairs.size(), 2 * n_selectors + n_datasets);
    for (std::size_t i = rows.size(); i > 1; --i) {
      std::swap(rows[i - 1], rows[random.index(static_cast<std::uint32_t>(i))]);
    }
    EXPECT_EQ(names(chooseExamples(rows, kTau, 1000)), names(pairs)) << "round " << round;
  }
}

}  // namespace
}  // namespace corrsel::core
